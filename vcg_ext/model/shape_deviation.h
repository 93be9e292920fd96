// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// How unusual a shape is beside those that a model was built from.

#include <Eigen/Core>

namespace sphere_propagation {

struct ShapeDeviation {
  /// sqrt((b^T D^-1 b) / #q), b the scores, D the variances of the q modes that count: 1 for a
  /// shape as far from the mean as shapes are on average.
  double deviation = 0;
  /// Share of the training shapes, each measured by the model of all others, that deviate less; NaN
  /// where that is not known.
  double percentile = 0;
  Eigen::Index modes = 0;    ///< q: the fewest with 95 % of the variance, at most half as many as
                             ///< shapes; what comes later is measured too badly to divide by
  Eigen::VectorXd training;  ///< of each training shape
};

/// For training shape k the scatter of the others about their own mean is D - rho x x^T, rho = #K /
/// (#K - 1), and the shape lies at rho x from that mean (leave_one_out.h), so that
///   deviation^2 #q = (#K - 2) rho^2 s / (1 - rho s),    s = x^T D^-1 x,
/// by the formula of Sherman and Morrison.
///
/// scores: of the shape, length >= modes; training: #K by #M, as ShapeModel has them; eigenvalues:
/// #M. Fewer than four training shapes tell nothing: percentile is NaN.
ShapeDeviation shapeDeviation(const Eigen::VectorXd& scores, const Eigen::MatrixXd& training,
                              const Eigen::VectorXd& eigenvalues);

}  // namespace sphere_propagation
