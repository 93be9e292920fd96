// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A label volume of one phase, as it lies in space.

#include <cstdint>
#include <limits>
#include <map>

#include "vcg_ext/volume/grid.h"

namespace sphere_propagation {

/// The label of each voxel; 0 is the background.
struct LabelGrid : Grid<std::int32_t> {
  /// Stands for every label of a file that 32 bits cannot hold, and that so cannot be asked for.
  static constexpr std::int32_t beyond = std::numeric_limits<std::int32_t>::min();

  /// (i, j, k, 1), the centre of a voxel, to mm; any affine map.
  Eigen::Matrix4d toWorld = Eigen::Matrix4d::Identity();

  /// Distances between neighbouring voxels along i, j, k, mm.
  Vector3 spacing() const { return toWorld.topLeftCorner<3, 3>().colwise().norm().transpose(); }
  /// mm^3.
  double voxelVolume() const;

  /// Throws VolumeError when there are no voxels, not as many labels as voxels, or when the affine
  /// map is not finite, has another last row than (0, 0, 0, 1), or maps the voxels into a plane.
  void check() const;

  /// How many voxels have each label, the background's 0 left out.
  std::map<std::int32_t, long> count() const;
};

}  // namespace sphere_propagation
