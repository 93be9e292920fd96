#include "vcg_ext/map/area_preserving_map.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "vcg_ext/map/area_minimiser.h"

namespace sphere_propagation {
namespace {

/// Weight of the shape term beside an area term of 1. Squares, so that the range in which the two balance spreads over the
/// slider; the least keeps faces from degenerating while areas travel, and is far below what can be seen in the areas.
double shapeWeight(double areaWeight) {
  constexpr double even = 0.02, least = 1e-6;
  const double ratio = (1 - areaWeight) / areaWeight;
  return std::max(even * ratio * ratio, least);
}

}  // namespace

AreaPreservingResult makeAreaPreserving(const ClosedSurface& surface, const SphereMap& start,
                                        const AreaPreservingParameters& parameters, const Progress& progress) {
  if (!(parameters.areaWeight >= 0 && parameters.areaWeight <= 1))
    throw ParameterError("The area weight must lie between 0 and 1; it is " + std::to_string(parameters.areaWeight) + ".");
  AreaMinimiser minimiser(surface, faceTargets(surface.vertices(), surface.faces()));
  AreaPreservingResult result{start, 0};
  Points positions = start.positions();

  constexpr double first = 0.3, decay = 0.25;  // of the shape weight, from stage to stage
  constexpr int stepsAtMost = 40;              // of a stage
  constexpr double enough = 0.985;             // a step that lowers the energy by less ends its stage
  const bool anglesOnly = parameters.areaWeight == 0;
  const double last = anglesOnly ? 1 : shapeWeight(parameters.areaWeight);
  const int stages = last >= first ? 1 : 1 + static_cast<int>(std::ceil(std::log(last / first) / std::log(decay)));
  AreaStepParameters step;
  step.weights = {anglesOnly ? 0.0 : 1.0, first};
  for (int stage = 0; stage < stages; ++stage) {
    step.weights.shape = stage + 1 == stages ? last : first * std::pow(decay, stage);
    for (int i = 0; i < stepsAtMost; ++i) {
      const double ratio = minimiser.step(step, positions);
      if (ratio < 1) ++result.steps;
      report(progress, (stage + std::min(1.0, (i + 1.0) / 10)) / stages);
      if (ratio > enough) break;
    }
    step.damping = std::max(0.5 * step.damping, 1e-4);
  }
  result.map = SphereMap(surface, std::move(positions));
  report(progress, 1);
  return result;
}

}  // namespace sphere_propagation
