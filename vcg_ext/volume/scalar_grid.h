// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A scalar image on a regular grid, as it lies in space.

#include <cstddef>
#include <vector>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

struct ScalarGrid {
  Eigen::Vector3i size = Eigen::Vector3i::Zero();  ///< samples along x, y, z
  Vector3 origin = Vector3::Zero();                ///< where sample (0, 0, 0) lies, mm
  Vector3 spacing = Vector3::Ones();               ///< between samples along x, y, z, mm, positive
  std::vector<float> values;                       ///< size.prod() samples, x fastest, z slowest

  ScalarGrid() = default;
  /// All samples 0.
  ScalarGrid(const Eigen::Vector3i& gridSize, const Vector3& gridOrigin, const Vector3& gridSpacing)
      : size(gridSize), origin(gridOrigin), spacing(gridSpacing) {
    values.resize(static_cast<size_t>(size[0]) * static_cast<size_t>(size[1]) *
                  static_cast<size_t>(size[2]));
  }

  size_t index(int i, int j, int k) const {
    return (static_cast<size_t>(k) * static_cast<size_t>(size[1]) + static_cast<size_t>(j)) *
               static_cast<size_t>(size[0]) +
           static_cast<size_t>(i);
  }
  float& operator()(int i, int j, int k) { return values[index(i, j, k)]; }
  float operator()(int i, int j, int k) const { return values[index(i, j, k)]; }
};

}  // namespace sphere_propagation
