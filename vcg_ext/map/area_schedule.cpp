#include "vcg_ext/map/area_schedule.h"

#include <algorithm>
#include <cmath>

namespace sphere_propagation {

int minimiseInStages(AreaMinimiser& minimiser, const AreaEnergyWeights& weights, Points& positions,
                     const Progress& progress, double firstShape) {
  constexpr double decay = 0.25;   // of the shape weight, from stage to stage
  constexpr int stepsAtMost = 40;  // of a stage
  // Large meshes come from a hierarchy and are nearly there; more would cost much and be seen in the figures alone.
  const bool isLarge = positions.rows() > 100000;
  // A step that lowers the energy by less ends its stage: what the next stage does anyway need not be done here. The
  // shape term alone has a minimum far above 0.
  const double enough = weights.area > 0 ? (isLarge ? 0.985 : 0.997) : 0.999;
  const double enoughForNow = weights.area > 0 ? 0.96 : enough;
  const double last = weights.shape;
  const int stages =
      last >= firstShape ? 1 : 1 + static_cast<int>(std::ceil(std::log(last / firstShape) / std::log(decay)));
  AreaStepParameters step;
  step.weights = weights;
  step.damping = 0.003;
  step.conjugateGradientIterations = isLarge ? 60 : 100;
  int steps = 0, taken = 0;
  for (int stage = 0; stage < stages; ++stage) {
    const bool isLast = stage + 1 == stages;
    step.weights.shape = isLast ? last : firstShape * std::pow(decay, stage);
    for (int i = 0; i < stepsAtMost; ++i) {
      const double ratio = minimiser.step(step, positions);
      if (ratio < 1) ++steps;
      report(progress, 1 - std::pow(0.88, ++taken));  // nobody knows how many there will be
      if (ratio > (isLast ? enough : enoughForNow)) break;
    }
    step.damping = std::max(0.5 * step.damping, 1e-4);
  }
  return steps;
}

}  // namespace sphere_propagation
