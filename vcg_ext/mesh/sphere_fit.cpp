// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/sphere_fit.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

namespace sphere_propagation {

double deviationFromSphere(const Points& points) {
  // |q - c|^2 = r^2 is linear in c and d = r^2 - |c|^2: 2 q.c + d = |q|^2. Solved with q about the
  // mean, of extent 1.
  const double none = std::numeric_limits<double>::infinity();
  const Eigen::RowVector3d mean = points.colwise().mean();
  const double extent = (points.rowwise() - mean).cwiseAbs().maxCoeff();
  if (!(extent > 0)) return none;
  const Points q = (points.rowwise() - mean) / extent;
  Eigen::MatrixXd system(q.rows(), 4);
  system << 2 * q, Eigen::VectorXd::Ones(q.rows());
  const Eigen::LDLT<Eigen::Matrix4d> normal(system.transpose() * system);
  const Eigen::Vector4d solution = normal.solve(system.transpose() * q.rowwise().squaredNorm());
  const double squaredRadius = solution[3] + solution.head<3>().squaredNorm();
  if (!solution.allFinite() ||
      !(normal.vectorD().minCoeff() > 1e-12 * normal.vectorD().maxCoeff()) || squaredRadius <= 0)
    return none;
  const double radius = std::sqrt(squaredRadius);
  const Eigen::VectorXd distances = (q.rowwise() - solution.head<3>().transpose()).rowwise().norm();
  return (distances.array() / radius - 1).abs().maxCoeff();
}

}  // namespace sphere_propagation
