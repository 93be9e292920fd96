// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A binary image: which voxels of a grid are inside.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

struct Mask {
  Eigen::Vector3i size = Eigen::Vector3i::Zero();  ///< voxels along x, y, z
  std::vector<std::uint8_t> inside;  ///< size.prod() values, 0 or 1, x fastest, z slowest

  Mask() = default;
  /// All voxels outside.
  explicit Mask(const Eigen::Vector3i& gridSize) : size(gridSize) {
    inside.resize(static_cast<size_t>(size[0]) * static_cast<size_t>(size[1]) *
                  static_cast<size_t>(size[2]));
  }

  size_t index(int i, int j, int k) const {
    return (static_cast<size_t>(k) * static_cast<size_t>(size[1]) + static_cast<size_t>(j)) *
               static_cast<size_t>(size[0]) +
           static_cast<size_t>(i);
  }
  std::uint8_t& operator()(int i, int j, int k) { return inside[index(i, j, k)]; }
  std::uint8_t operator()(int i, int j, int k) const { return inside[index(i, j, k)]; }
};

}  // namespace sphere_propagation
