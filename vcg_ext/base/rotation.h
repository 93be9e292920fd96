// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The rotation that turns one set of vectors onto another.

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace sphere_propagation {

/// The proper rotation R that minimises sum w_i |R x_i - y_i|^2, given sum w_i y_i x_i^T (W.
/// Kabsch, A solution for the best rotation to relate two sets of vectors, 1976).
inline Eigen::Matrix3d bestRotation(const Eigen::Matrix3d& covariance) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  // No reflection: the direction that matters least is the one turned round.
  const double handedness = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Eigen::Vector3d(1, 1, handedness).asDiagonal() * svd.matrixV().transpose();
}

}  // namespace sphere_propagation
