#include "vcg_ext/map/area_preserving_map.h"

#include <algorithm>
#include <string>
#include <utility>

#include "vcg_ext/map/area_minimiser.h"
#include "vcg_ext/map/area_schedule.h"

namespace sphere_propagation {
namespace {

/// Weight of the shape term beside an area term of 1. Squares, so that the range in which the two balance spreads over
/// the slider; the least keeps faces from degenerating while areas travel, and is far below what can be seen in the
/// areas.
double shapeWeight(double areaWeight) {
  constexpr double even = 0.02, least = 1e-6;
  const double ratio = (1 - areaWeight) / areaWeight;
  return std::max(even * ratio * ratio, least);
}

}  // namespace

AreaPreservingResult makeAreaPreserving(const ClosedSurface& surface, const SphereMap& start,
                                        const AreaPreservingParameters& parameters, const Progress& progress) {
  if (!(parameters.areaWeight >= 0 && parameters.areaWeight <= 1))
    throw ParameterError("The area weight must lie between 0 and 1; it is " + std::to_string(parameters.areaWeight) +
                         ".");
  AreaMinimiser minimiser(surface, faceTargets(surface.vertices(), surface.faces()));
  AreaPreservingResult result{start, 0};
  Points positions = start.positions();

  const bool anglesOnly = parameters.areaWeight == 0;
  const AreaEnergyWeights weights{anglesOnly ? 0.0 : 1.0, anglesOnly ? 1.0 : shapeWeight(parameters.areaWeight)};
  result.steps = minimiseInStages(minimiser, weights, positions, progress);
  result.map = SphereMap(surface, std::move(positions));
  report(progress, 1);
  return result;
}

}  // namespace sphere_propagation
