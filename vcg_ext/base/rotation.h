// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The rotation that turns one set of vectors onto another.

#include <Eigen/Core>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// The proper rotation R that minimises sum w_i |R x_i - y_i|^2, given sum w_i y_i x_i^T
/// (W. Kabsch, A solution for the best rotation to relate two sets of vectors, 1976).
Eigen::Matrix3d bestRotation(const Eigen::Matrix3d& covariance);

/// Whether points leave the turn about a line open: from the point that is farthest from their
/// centroid, through that, none lies farther off the line than 1e-6 of that distance. points: #P by
/// 3, finite, #P >= 1.
bool liesOnLine(const Points& points);

}  // namespace sphere_propagation
