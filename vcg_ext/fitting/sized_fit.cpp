// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/fitting/sized_fit.h"

#include <algorithm>

namespace sphere_propagation {

SizedFit fitOfOwnSize(const FittingModel& model, const FittingTarget& target, const ModelFit& fit,
                      const ModelFitParameters& parameters, ThreadPool& pool) {
  constexpr Eigen::Index landmarks = 250;
  ModelFitParameters again = parameters;
  again.thinning = static_cast<int>(std::max<Eigen::Index>(1, model.mean().rows() / landmarks));
  again.pose = RigidMotion{fit.rotation, fit.translation};
  again.scale = fit.scale;
  again.scales = false;
  const double held = fitModel(model, target, pool, again).logPosterior;
  again.scales = true;
  const ModelFit sized = fitModel(model, target, pool, again);
  return {sized.logPosterior - held, sized.scale};
}

}  // namespace sphere_propagation
