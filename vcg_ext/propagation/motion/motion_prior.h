// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What is expected of the motion from one surface to the next before the next one is seen.

#include <Eigen/Core>

namespace sphere_propagation {

/// Variances of the four blocks of coefficients of a motion model, in units of half its mean vertex
/// area.
struct MotionVariances {
  double local = 1, translation = 1, strain = 1, rotation = 1;
  /// One entry per column of the model.
  Eigen::VectorXd diagonal() const;
};

/// The coefficients' change along an arc is normal with mean zero and this precision.
struct MotionPrior {
  Eigen::MatrixXd precision;  ///< Sigma^-1, columns by columns
  double noise = 6;           ///< kappa, of the observations (motion_fit.h)

  /// Independent coefficients.
  static MotionPrior of(const MotionVariances& variances, double noise);

  /// Sigma with the variances of the four blocks multiplied, correlations as they are.
  MotionPrior withVariancesTimes(const MotionVariances& factors) const;
};

/// The prior where there is too little to learn from (motion_learning.h).
MotionPrior fixedMotionPrior();

}  // namespace sphere_propagation
