#include "vcg_ext/map/area_schedule.h"

#include <algorithm>
#include <cmath>

namespace sphere_propagation {

int minimiseInStages(AreaMinimiser& minimiser, const AreaEnergyWeights& weights, Points& positions,
                     const Progress& progress) {
  constexpr double first = 0.3, decay = 0.25;  // of the shape weight, from stage to stage
  constexpr int stepsAtMost = 40;              // of a stage
  // A step that lowers the energy by less ends its stage. The shape term alone has a minimum far above 0.
  const double enough = weights.area > 0 ? 0.985 : 0.999;
  const double last = weights.shape;
  const int stages = last >= first ? 1 : 1 + static_cast<int>(std::ceil(std::log(last / first) / std::log(decay)));
  AreaStepParameters step;
  step.weights = weights;
  int steps = 0;
  for (int stage = 0; stage < stages; ++stage) {
    step.weights.shape = stage + 1 == stages ? last : first * std::pow(decay, stage);
    for (int i = 0; i < stepsAtMost; ++i) {
      const double ratio = minimiser.step(step, positions);
      if (ratio < 1) ++steps;
      report(progress, (stage + std::min(1.0, (i + 1.0) / 10)) / stages);
      if (ratio > enough) break;
    }
    step.damping = std::max(0.5 * step.damping, 1e-4);
  }
  return steps;
}

}  // namespace sphere_propagation
