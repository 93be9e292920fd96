// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Regular grids of values: binary and scalar images. Labels are in label_grid.h.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

template <class Value>
struct Grid {
  Eigen::Vector3i size = Eigen::Vector3i::Zero();  ///< voxels along x, y, z
  std::vector<Value> values;                       ///< size.prod(), x fastest, z slowest

  Grid() = default;
  /// All values 0.
  explicit Grid(const Eigen::Vector3i& gridSize) : size(gridSize) { values.resize(voxelCount()); }

  size_t index(int i, int j, int k) const {
    return (static_cast<size_t>(k) * static_cast<size_t>(size[1]) + static_cast<size_t>(j)) *
               static_cast<size_t>(size[0]) +
           static_cast<size_t>(i);
  }
  /// size.prod(), which may be more than an int holds.
  size_t voxelCount() const { return index(0, 0, size[2]); }
  Value& operator()(int i, int j, int k) { return values[index(i, j, k)]; }
  Value operator()(int i, int j, int k) const { return values[index(i, j, k)]; }
};

/// A binary image: 1 for the voxels inside, 0 for those outside.
using Mask = Grid<std::uint8_t>;

/// A scalar image as it lies in space.
struct ScalarGrid : Grid<float> {
  Vector3 origin = Vector3::Zero();   ///< where sample (0, 0, 0) lies, mm
  Vector3 spacing = Vector3::Ones();  ///< between samples along x, y, z, mm, positive

  ScalarGrid() = default;
  /// All samples 0.
  ScalarGrid(const Eigen::Vector3i& gridSize, const Vector3& gridOrigin, const Vector3& gridSpacing)
      : Grid(gridSize), origin(gridOrigin), spacing(gridSpacing) {}
};

}  // namespace sphere_propagation
