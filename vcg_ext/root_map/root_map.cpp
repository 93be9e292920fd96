// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/root_map/root_map.h"

#include <limits>
#include <utility>
#include <vector>

#include "vcg_ext/area/area_preserving_map.h"
#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/root_map/brechbuehler_map.h"
#include "vcg_ext/root_map/harmonic_map.h"
#include "vcg_ext/root_map/hierarchical_map.h"
#include "vcg_ext/sphere/repair/untangling.h"

namespace sphere_propagation {
namespace {

/// The starts to try, the one that is asked for first.
std::vector<InitialMap> startsToTry(InitialMap asked) {
  if (asked == InitialMap::Brechbuehler)
    return {InitialMap::Brechbuehler, InitialMap::Hierarchical, InitialMap::Harmonic};
  if (asked == InitialMap::Harmonic)
    return {InitialMap::Harmonic, InitialMap::Hierarchical, InitialMap::Brechbuehler};
  return {InitialMap::Hierarchical, InitialMap::Harmonic, InitialMap::Brechbuehler};
}

RootMapResult mapFrom(InitialMap start, const ClosedSurface& surface, double areaWeight,
                      ThreadPool& pool, const Progress& progress) {
  if (start == InitialMap::Hierarchical) {
    HierarchicalResult result = hierarchicalMap(surface, energyWeights(areaWeight), pool, progress);
    return {MappedSurface(surface, std::move(result.positions)),
            start,
            result.levels,
            0,
            result.steps,
            ""};
  }
  constexpr double startsShare = 0.15;  // of the time
  const Untangled initial =
      untangle(surface,
               start == InitialMap::Brechbuehler ? brechbuehlerPositions(surface)
                                                 : harmonicPositions(surface),
               std::numeric_limits<int>::max(), part(progress, 0, startsShare));
  AreaPreservingResult result =
      makeAreaPreserving(initial.map, {areaWeight}, part(progress, startsShare, 1), &pool);
  return {std::move(result.map), start, 1, initial.repairedFaces, result.steps, ""};
}

}  // namespace

std::string nameOf(InitialMap start) {
  switch (start) {
    case InitialMap::Brechbuehler:
      return "Brechbuehler";
    case InitialMap::Harmonic:
      return "Harmonic";
    case InitialMap::Hierarchical:
      return "Hierarchical";
    default:
      return "Automatic";
  }
}

RootMapResult makeRootMap(const ClosedSurface& surface, const RootMapParameters& parameters,
                          const Progress& progress) {
  requireRange("number of threads", parameters.threads, Range::atLeast(0));
  energyWeights(parameters.areaWeight);  // before anything is done
  report(progress, 0);
  ThreadPool pool(surface.vertexCount() < ThreadPool::worthwhile ? 1 : parameters.threads);
  std::string failures;
  long fewest = std::numeric_limits<long>::max(), first = -1;
  for (const InitialMap start : startsToTry(parameters.initialMap)) {
    try {
      RootMapResult result = mapFrom(start, surface, parameters.areaWeight, pool, progress);
      result.failures = failures;
      report(progress, 1);
      return result;
    } catch (const MapError& error) {
      failures += (failures.empty() ? "" : ", ") + nameOf(start) + " cannot be made valid (" +
                  std::to_string(error.finding().count) +
                  (start == InitialMap::Hierarchical
                       ? " vertices find no place)"
                       : " of " + std::to_string(surface.faceCount()) + " faces stay flipped)");
      if (error.finding().count < fewest)
        fewest = error.finding().count, first = error.finding().first;
    }
  }
  throw MapError(
      Finding(Fault::NoValidMap, surface.name()).of(fewest, first).saying(std::move(failures)));
}

}  // namespace sphere_propagation
