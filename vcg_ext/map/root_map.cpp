#include "vcg_ext/map/root_map.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "vcg_ext/map/area_preserving_map.h"
#include "vcg_ext/map/brechbuehler_map.h"
#include "vcg_ext/map/harmonic_map.h"
#include "vcg_ext/map/tutte_map.h"
#include "vcg_ext/map/untangling.h"

namespace sphere_propagation {
namespace {

/// The starts to try, the one that is asked for first.
std::vector<InitialMap> startsToTry(InitialMap asked) {
  std::vector<InitialMap> starts{InitialMap::Harmonic, InitialMap::Brechbuehler, InitialMap::Tutte};
  const auto first = std::find(starts.begin(), starts.end(), asked);
  if (first != starts.end()) std::rotate(starts.begin(), first, first + 1);
  return starts;
}

Points initialPositions(const ClosedSurface& surface, InitialMap start) {
  if (start == InitialMap::Brechbuehler) return brechbuehlerPositions(surface);
  return start == InitialMap::Harmonic ? harmonicPositions(surface) : tuttePositions(surface);
}

}  // namespace

std::string nameOf(InitialMap start) {
  switch (start) {
    case InitialMap::Brechbuehler:
      return "Brechbuehler";
    case InitialMap::Harmonic:
      return "Harmonic";
    case InitialMap::Tutte:
      return "Tutte";
    default:
      return "Automatic";
  }
}

RootMapResult makeRootMap(const ClosedSurface& surface, const RootMapParameters& parameters, const Progress& progress) {
  const std::string layer = "Layer \"" + surface.name() + "\"";
  report(progress, 0);
  std::string failures;
  long fewest = std::numeric_limits<long>::max(), first = -1;
  for (const InitialMap start : startsToTry(parameters.initialMap)) {
    std::optional<Untangled> initial;
    try {
      initial = untangle(surface, initialPositions(surface, start));
    } catch (const MapError& error) {
      failures += (failures.empty() ? "" : ", ") + nameOf(start) + " cannot be made valid (" +
                  std::to_string(error.count) + " of " + std::to_string(surface.faceCount()) + " faces stay flipped)";
      if (error.count < fewest) fewest = error.count, first = error.first;
      continue;
    }
    constexpr double startsShare = 0.15;  // of the time
    AreaPreservingResult result =
        makeAreaPreserving(surface, initial->map, {parameters.areaWeight}, part(progress, startsShare, 1));
    std::string note;
    if (!failures.empty())
      note.append(layer)
          .append(": the initial map is ")
          .append(nameOf(start))
          .append(", since ")
          .append(failures)
          .append(".");
    return {std::move(result.map), start, initial->repairedFaces, result.steps, std::move(note)};
  }
  throw MapError(fewest, first,
                 layer + " gets no valid map to the sphere: " + failures +
                     ". The surface may have very thin or folded parts near face " + std::to_string(first) +
                     ": remesh it with \"Remeshing: Isotropic Explicit Remeshing\" and run this filter again.");
}

}  // namespace sphere_propagation
