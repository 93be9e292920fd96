// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_prior.h"

#include "vcg_ext/propagation/motion/motion_model.h"

namespace sphere_propagation {

Eigen::VectorXd MotionVariances::diagonal() const {
  Eigen::VectorXd d(MotionBasis::columns);
  d << Eigen::VectorXd::Constant(MotionBasis::localColumns, local),
      Eigen::VectorXd::Constant(MotionBasis::translationColumns, translation),
      Eigen::VectorXd::Constant(MotionBasis::strainColumns, strain),
      Eigen::VectorXd::Constant(MotionBasis::rotationColumns, rotation);
  return d;
}

MotionPrior MotionPrior::of(const MotionVariances& variances, double noise) {
  return {variances.diagonal().cwiseInverse().asDiagonal(), noise};
}

MotionPrior MotionPrior::withVariancesTimes(const MotionVariances& factors) const {
  const Eigen::VectorXd share = factors.diagonal().cwiseSqrt().cwiseInverse();
  return {share.asDiagonal() * precision * share.asDiagonal(), noise};
}

MotionPrior fixedMotionPrior() { return MotionPrior::of({1, 0.5, 1, 0.3}, 6); }

}  // namespace sphere_propagation
