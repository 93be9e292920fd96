// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/shape_deviation.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sphere_propagation {
namespace {

Eigen::Index modesThatCount(const Eigen::VectorXd& eigenvalues, Eigen::Index most) {
  constexpr double share = 0.95;
  const double total = eigenvalues.sum();
  double sum = 0;
  Eigen::Index modes = 0;
  while (modes < most && eigenvalues[modes] > 0 && (modes == 0 || sum < share * total))
    sum += eigenvalues[modes++];
  return modes;
}

}  // namespace

ShapeDeviation shapeDeviation(const Eigen::VectorXd& scores, const Eigen::MatrixXd& training,
                              const Eigen::VectorXd& eigenvalues) {
  constexpr Eigen::Index fewest = 4;
  const Eigen::Index shapes = training.rows();
  const bool known = shapes >= fewest;
  ShapeDeviation result;
  result.percentile = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Index most = std::min(scores.size(), eigenvalues.size());
  result.modes = modesThatCount(eigenvalues, known ? std::min(most, shapes / 2) : most);
  const Eigen::Index q = result.modes;
  if (q == 0) return result;
  const Eigen::ArrayXd variances = eigenvalues.head(q);
  const auto count = static_cast<double>(q);
  result.deviation = std::sqrt((scores.head(q).array().square() / variances).sum() / count);
  if (!known) return result;
  const auto all = static_cast<double>(shapes);
  const double rho = all / (all - 1);
  result.training.resize(shapes);
  for (Eigen::Index k = 0; k < shapes; ++k) {
    const double s =
        (training.row(k).head(q).transpose().array().square() / ((all - 1) * variances)).sum();
    // 0 where the others do not vary in the direction of this shape.
    const double left = std::max(1 - rho * s, std::numeric_limits<double>::epsilon());
    result.training[k] = std::sqrt((all - 2) * rho * rho * s / left / count);
  }
  result.percentile =
      static_cast<double>((result.training.array() < result.deviation).count()) / all;
  return result;
}

}  // namespace sphere_propagation
