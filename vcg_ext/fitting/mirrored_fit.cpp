// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/fitting/mirrored_fit.h"

#include <limits>
#include <utility>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

constexpr int iterations = 8, starts = 6;

}  // namespace

double advantageOfMirrorImage(const FittingModel& model, const FittingTarget& target,
                              const ModelFit& fit, bool scales, ThreadPool& pool) {
  ModelFitParameters parameters;
  parameters.scales = scales;
  parameters.iterations = iterations;
  parameters.starts = starts;
  parameters = onceMoreFrom(fit, model, std::move(parameters));
  const double itself = fitModel(model, target, pool, parameters).logPosterior;
  parameters.pose = std::nullopt;
  try {
    return fitModel(model, target.mirrored(), pool, parameters).logPosterior - itself;
  } catch (const SurfaceError&) {
    return -std::numeric_limits<double>::infinity();
  }
}

}  // namespace sphere_propagation
