// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/rotation.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <vector>

namespace sphere_propagation {

Eigen::Matrix3d bestRotation(const Eigen::Matrix3d& covariance) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  // No reflection: the direction that matters least is the one turned round.
  const double handedness = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Eigen::Vector3d(1, 1, handedness).asDiagonal() * svd.matrixV().transpose();
}

bool liesOnLine(const Points& points) {
  const Points centred = points.rowwise() - points.colwise().mean();
  Eigen::Index farthest = 0;
  const double most = std::sqrt(centred.rowwise().squaredNorm().maxCoeff(&farthest));
  if (most == 0) return true;
  const Eigen::RowVector3d along = centred.row(farthest) / most;
  const Points across = centred - (centred * along.transpose()) * along;
  return across.rowwise().norm().maxCoeff() <= 1e-6 * most;
}

SharedPoints::SharedPoints(const Points& one, const Points& other) {
  std::vector<Eigen::Index> shared;
  for (Eigen::Index k = 0; k < one.rows(); ++k)
    if (one.row(k).allFinite() && other.row(k).allFinite()) shared.push_back(k);
  first = one(shared, Eigen::all);
  second = other(shared, Eigen::all);
}

bool SharedPoints::fixPose() const {
  return count() >= minPosePoints && !liesOnLine(first) && !liesOnLine(second);
}

}  // namespace sphere_propagation
