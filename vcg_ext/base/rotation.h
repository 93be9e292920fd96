// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The rotation that turns one set of vectors onto another, and when points tell it.

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

/// Fewer pairs of points leave a pose open.
constexpr int minPosePoints = 3;

/// The rows that both have: one that is not finite is a point that is missing.
struct SharedPoints {
  /// As many rows each.
  SharedPoints(const Points& one, const Points& other);
  Eigen::Index count() const { return first.rows(); }
  /// Whether they tell how the one lies to the other: minPosePoints, not on one line.
  bool fixPose() const;

  Points first, second;
};

}  // namespace sphere_propagation
