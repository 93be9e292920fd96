// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/registration/rigid_alignment.h"

#include <Eigen/LU>
#include <string>
#include <utility>
#include <vector>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/rotation.h"

namespace sphere_propagation {

Points RigidMotion::applyTo(const Points& points) const {
  return (points * rotation.transpose()).rowwise() + translation.transpose();
}

RigidMotion RigidMotion::inverse() const {
  const Eigen::Matrix3d back = rotation.transpose();
  return {back, -back * translation};
}

RigidMotion operator*(const RigidMotion& a, const RigidMotion& b) {
  return {a.rotation * b.rotation, a.rotation * b.translation + a.translation};
}

RigidMotion fitRigid(const Points& from, const Points& to) {
  if (from.rows() == 0 || from.rows() != to.rows())
    throw ArgumentError(
        "A rigid motion is fitted to as many points as it is to reach, and to at least one; given "
        "are " +
        std::to_string(from.rows()) + " and " + std::to_string(to.rows()) + ".");
  const Eigen::RowVector3d fromCentroid = from.colwise().mean(), toCentroid = to.colwise().mean();
  const Eigen::Matrix3d covariance =
      (to.rowwise() - toCentroid).transpose() * (from.rowwise() - fromCentroid);
  RigidMotion motion;
  motion.rotation = bestRotation(covariance);
  motion.translation = toCentroid.transpose() - motion.rotation * fromCentroid.transpose();
  return motion;
}

std::optional<RigidMotion> fitRigidWhereShared(const Points& from, const Points& to) {
  if (from.rows() != to.rows())
    throw ArgumentError("Points that are missing need rows of their own: given are " +
                        std::to_string(from.rows()) + " and " + std::to_string(to.rows()) + ".");
  const SharedPoints shared(from, to);
  if (!shared.fixPose()) return std::nullopt;
  return fitRigid(shared.first, shared.second);
}

RigidAlignment alignRigidly(const Points& points, const VertexLocator& reference, int iterations) {
  requireRange("number of alignment iterations", iterations, Range::atLeast(0));
  if (points.rows() == 0) throw ArgumentError("There is no point to align.");
  RigidAlignment result;
  std::vector<int> before;
  Points targets(points.rows(), 3);
  while (result.iterations < iterations) {
    std::vector<int> pairs = reference.nearest(result.motion.applyTo(points), before);
    if (pairs == before) {
      result.converged = true;
      break;
    }
    for (size_t v = 0; v < pairs.size(); ++v)
      targets.row(static_cast<Eigen::Index>(v)) = reference.points().row(pairs[v]);
    // From where the points began: the motion of all iterations together, without their rounding.
    result.motion = fitRigid(points, targets);
    before = std::move(pairs);
    ++result.iterations;
  }
  return result;
}

}  // namespace sphere_propagation
