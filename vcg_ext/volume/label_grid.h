// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A label volume of one phase, as it lies in space.

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

struct LabelGrid {
  Eigen::Vector3i size = Eigen::Vector3i::Zero();  ///< voxels along i, j, k
  Eigen::Matrix4d toWorld =
      Eigen::Matrix4d::Identity();   ///< (i, j, k, 1), the centre of a voxel, to mm; any affine map
  std::vector<std::int32_t> labels;  ///< size.prod() values, i fastest, k slowest

  size_t index(int i, int j, int k) const {
    return (static_cast<size_t>(k) * static_cast<size_t>(size[1]) + static_cast<size_t>(j)) *
               static_cast<size_t>(size[0]) +
           static_cast<size_t>(i);
  }
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
