// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// How the errors of a surface's points hang together.
///
/// A surface from voxels is wrong along its normal, and flat parts that lie along the grid are
/// wrong as a whole, by a part of a voxel, all their nodes together. So two points with unit
/// normals n have errors of covariance
///   exp(-|n_i - n_j|^2 / 2 a^2 - (n_i . X_i - n_j . X_j)^2 / 2 b^2),   a = 0.45, b half an edge,
/// times their variance: those that face alike and lie in one plane err together.

#include <Eigen/Core>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// At most so many columns are made of the covariance's factor, and none that would explain less
/// than this share of any node's variance.
constexpr int maxErrorColumns = 100;
constexpr double minErrorShare = 0.05;

/// F with F F^T close to the covariance, by pivoted Cholesky decomposition: #N by at most
/// maxErrorColumns. points, normals: #N by 3; a node whose normal is zero has no part in it, and a
/// row of zeros; edge: the surface's mean edge length.
Eigen::MatrixXd surfaceErrorFactor(const Points& points, const Points& normals, double edge);

}  // namespace sphere_propagation
