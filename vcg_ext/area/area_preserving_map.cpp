// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/area/area_preserving_map.h"

#include <algorithm>
#include <string>
#include <utility>

#include "vcg_ext/area/area_minimiser.h"
#include "vcg_ext/area/area_schedule.h"

namespace sphere_propagation {
namespace {

/// Weight of the shape term beside an area term of 1. Squares, so that the range in which the two
/// balance spreads over the slider.
double shapeWeight(double areaWeight) {
  constexpr double even = 0.02;
  const double ratio = (1 - areaWeight) / areaWeight;
  return std::max(even * ratio * ratio, minShapeWeight);
}

}  // namespace

AreaEnergyWeights energyWeights(double areaWeight) {
  requireRange("area weight", areaWeight, Range::between(0, 1));
  return areaWeight == 0 ? AreaEnergyWeights{0, 1} : AreaEnergyWeights{1, shapeWeight(areaWeight)};
}

AreaPreservingResult makeAreaPreserving(const MappedSurface& start,
                                        const AreaPreservingParameters& parameters,
                                        const Progress& progress, ThreadPool* pool) {
  const AreaEnergyWeights weights = energyWeights(parameters.areaWeight);
  const ClosedSurface& surface = start.surface();
  AreaMinimiser minimiser(surface, faceTargets(surface.vertices(), surface.faces()), pool);
  minimiser.hold(parameters.held);
  AreaPreservingResult result{start, 0};
  Points positions = start.positions();
  result.steps = minimiseInStages(minimiser, weights, positions, progress);
  result.map = MappedSurface(surface, std::move(positions));
  report(progress, 1);
  return result;
}

}  // namespace sphere_propagation
