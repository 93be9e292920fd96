// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Rigid alignment of point clouds: step 4b of the paper.

#include <optional>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/mesh/vertex_locator.h"

namespace sphere_propagation {

/// x -> rotation x + translation; a proper rotation.
struct RigidMotion {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vector3 translation = Vector3::Zero();
  /// points: #P by 3, moved.
  Points applyTo(const Points& points) const;
  bool isIdentity() const { return rotation.isIdentity(0) && translation.isZero(0); }
  RigidMotion inverse() const;
};

/// First b, then a.
RigidMotion operator*(const RigidMotion& a, const RigidMotion& b);

/// The rigid motion that brings the rows of `from` closest to those of `to` in the sum of squares
/// (W. Kabsch, A solution for the best rotation to relate two sets of vectors, 1976; no reflection:
/// S. Umeyama, Least-squares estimation of transformation parameters between two point patterns,
/// 1991, eq. 40, without scale). from, to: #P by 3, #P >= 1. Throws ParameterError when their sizes
/// differ or they are empty.
RigidMotion fitRigid(const Points& from, const Points& to);

/// The same by the rows that both have: a row that is not finite is a point that is missing. from,
/// to: as many rows. Nothing where the pose stays open: fewer than minPosePoints rows, or all on
/// one line (across it they spread by less than 1e-6 of what they do along it).
std::optional<RigidMotion> fitRigidWhereShared(const Points& from, const Points& to);

struct RigidAlignment {
  RigidMotion motion;
  int iterations = 0;      ///< fits that were made
  bool converged = false;  ///< whether the last search for nearest points changed nothing
};

/// Step 4b of the paper: iterative closest points (P. J. Besl and N. D. McKay, A method for
/// registration of 3-D shapes, 1992). Each iteration pairs every moved point with the nearest point
/// of the reference and fits the rigid motion; it stops when the pairs are those of the iteration
/// before, or after `iterations`. points: #P by 3; reference: the locator of its vertices;
/// iterations: >= 0, the paper's 30. Throws ParameterError when iterations is negative or there are
/// no points.
RigidAlignment alignRigidly(const Points& points, const VertexLocator& reference,
                            int iterations = 30);

}  // namespace sphere_propagation
