// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Label volumes of analytic shapes, for the tests of what makes surfaces of them.

#include <cmath>
#include <functional>

#include "tests/core/test_meshes.h"
#include "vcg_ext/volume/grid.h"
#include "vcg_ext/volume/label_grid.h"

namespace sphere_propagation::test {

/// Voxels whose centre is inside have label 1; the grid is centred on the origin.
inline LabelGrid labelsOf(const std::function<bool(const Vector3&)>& inside,
                          const Eigen::Vector3i& size, const Vector3& spacing = Vector3::Ones()) {
  LabelGrid grid;
  grid.size = size;
  grid.toWorld.topLeftCorner<3, 3>() = spacing.asDiagonal();
  grid.toWorld.topRightCorner<3, 1>() =
      -0.5 * (size.cast<double>() - Vector3::Ones()).cwiseProduct(spacing);
  grid.values.reserve(grid.voxelCount());
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i) {
        const Eigen::Vector4d x = grid.toWorld * Eigen::Vector4d(i, j, k, 1);
        grid.values.push_back(inside(x.head<3>()) ? 1 : 0);
      }
  return grid;
}

inline std::function<bool(const Vector3&)> ball(double radius,
                                                const Vector3& centre = Vector3::Zero()) {
  return [=](const Vector3& x) { return (x - centre).norm() < radius; };
}

/// Round the z axis.
inline std::function<bool(const Vector3&)> solidTorus(double ring, double tube) {
  return [=](const Vector3& x) { return std::hypot(std::hypot(x[0], x[1]) - ring, x[2]) < tube; };
}

/// A thick half shell, open at the top.
inline std::function<bool(const Vector3&)> thickCup(double inner, double outer) {
  return [=](const Vector3& x) { return x.norm() < outer && x.norm() > inner && x[2] < 0; };
}

/// Smoothed noise above 0: parts, cavities and handles in plenty. `share` of single voxels are then
/// turned round.
LabelGrid randomBlobs(unsigned seed, const Eigen::Vector3i& size, double smoothness, double share);

inline Mask maskOf(const LabelGrid& grid) {
  Mask mask(grid.size);
  for (size_t i = 0; i < mask.values.size(); ++i) mask.values[i] = grid.values[i] != 0;
  return mask;
}

}  // namespace sphere_propagation::test
