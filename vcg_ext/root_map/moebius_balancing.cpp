// SPDX-License-Identifier: GPL-3.0-only
// A. Baden, K. Crane, M. Kazhdan, Moebius registration, 2018, section 4.

#include "vcg_ext/root_map/moebius_balancing.h"

#include <cmath>

#include "vcg_ext/base/dense_cholesky.h"

namespace sphere_propagation {
namespace {

/// The hyperbolic translation of the ball that brings w to the centre, on a point of the sphere.
Vector3 translated(const Vector3& x, const Vector3& w) {
  const Vector3 d = x - w;
  return ((1 - w.squaredNorm()) / d.squaredNorm() * d - w).normalized();
}

/// The function whose minimum is the conformal barycentre (weighted mean of Busemann functions), 0
/// at the centre.
double energy(const Points& positions, const Eigen::VectorXd& weights, const Vector3& w) {
  double sum = 0;
  for (Eigen::Index i = 0; i < positions.rows(); ++i)
    sum += weights[i] * std::log((positions.row(i).transpose() - w).squaredNorm());
  return sum - std::log1p(-w.squaredNorm());
}

}  // namespace

Points balanceByMoebius(Points positions, const Eigen::VectorXd& weights) {
  const Eigen::VectorXd shares = weights / weights.sum();
  for (int step = 0; step < 200; ++step) {
    const Vector3 mean = positions.transpose() * shares;
    if (!(mean.norm() > 1e-12)) break;
    // The energy at w is -2 mean.w + 2 w.(I - sum of shares x x^T) w + ... A floor keeps it regular
    // where all x are collinear.
    const Eigen::Matrix3d hessian = (1 + 1e-9) * Eigen::Matrix3d::Identity() -
                                    positions.transpose() * shares.asDiagonal() * positions;
    Vector3 w = 0.5 * solveSymmetric(hessian, mean);
    if (w.norm() > 0.9) w *= 0.9 / w.norm();
    // Close to the end the decrease is below rounding; there the full step is right.
    while (mean.norm() > 1e-6 && energy(positions, shares, w) >= 0 && w.norm() > 1e-12) w /= 2;
    for (Eigen::Index i = 0; i < positions.rows(); ++i)
      positions.row(i) = translated(positions.row(i).transpose(), w).transpose();
  }
  return positions;
}

}  // namespace sphere_propagation
