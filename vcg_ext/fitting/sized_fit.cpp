// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/fitting/sized_fit.h"

namespace sphere_propagation {

SizedFit fitOfOwnSize(const FittingModel& model, const FittingTarget& target, const ModelFit& fit,
                      const ModelFitParameters& parameters, ThreadPool& pool) {
  ModelFitParameters again = onceMoreFrom(fit, model, parameters);
  again.scales = false;
  const double held = fitModel(model, target, pool, again).logPosterior;
  again.scales = true;
  const ModelFit sized = fitModel(model, target, pool, again);
  return {sized.logPosterior - held, sized.scale};
}

}  // namespace sphere_propagation
