// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The rotation that turns one set of vectors onto another.

#include <Eigen/Core>

namespace sphere_propagation {

/// The proper rotation R that minimises sum w_i |R x_i - y_i|^2, given sum w_i y_i x_i^T
/// (W. Kabsch, A solution for the best rotation to relate two sets of vectors, 1976).
Eigen::Matrix3d bestRotation(const Eigen::Matrix3d& covariance);

}  // namespace sphere_propagation
