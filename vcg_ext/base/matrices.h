// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The matrix types that every algorithm of vcg_ext speaks.

#include <Eigen/Core>

namespace sphere_propagation {

using Vector2 = Eigen::Vector2d;
using Vector3 = Eigen::Vector3d;
/// #P by 3 list of points or unit vectors, one a row (row-major: a point lies in one cache line).
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// #F by 3 list of vertex indices, one triangle a row, counter-clockwise seen from outside.
using Triangles = Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor>;

constexpr double pi = 3.14159265358979323846;

}  // namespace sphere_propagation
