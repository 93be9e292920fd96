// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/area/area_schedule.h"

#include <algorithm>
#include <cmath>

namespace sphere_propagation {

int minimiseInStages(AreaMinimiser& minimiser, const AreaEnergyWeights& weights, Points& positions,
                     const Progress& progress, const AreaSchedule& schedule) {
  constexpr double decay = 0.25;   // of the shape weight, from stage to stage
  constexpr int stepsAtMost = 80;  // of a stage
  const double last = weights.shape, felt = std::max(minShapeWeight, last);
  const int stages =
      felt >= schedule.firstShape
          ? 1
          : 1 + static_cast<int>(std::ceil(std::log(felt / schedule.firstShape) / std::log(decay)));
  AreaStepParameters step;
  step.weights = weights;
  step.damping = 0.003;
  step.conjugateGradientIterations = schedule.conjugateGradientIterations;
  int steps = 0, taken = 0;
  for (int stage = 0; stage < stages; ++stage) {
    const bool isLast = stage + 1 == stages;
    step.weights.shape = isLast ? last : schedule.firstShape * std::pow(decay, stage);
    for (int i = 0; i < stepsAtMost; ++i) {
      const double ratio = minimiser.step(step, positions);
      if (ratio < 1) ++steps;
      report(progress, 1 - std::pow(0.88, ++taken));  // nobody knows how many there will be
      if (ratio > (isLast ? schedule.atTheEnd : schedule.onTheWay)) break;
    }
    step.damping = std::max(0.5 * step.damping, 1e-4);
  }
  return steps;
}

}  // namespace sphere_propagation
