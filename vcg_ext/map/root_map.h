#pragma once
/// The map of the root of a propagation tree, from nothing but its surface.

#include <string>

#include "vcg_ext/base/progress.h"
#include "vcg_ext/map/sphere_map.h"

namespace sphere_propagation {

/// Where the minimisation of area distortion starts from. The map that it ends in is much the same from either.
enum class InitialMap {
  Automatic,     ///< the first of Harmonic, Brechbuehler, Tutte that can be made valid
  Brechbuehler,  ///< brechbuehler_map.h, the paper's
  Harmonic,      ///< harmonic_map.h: closer to the end, so about half the steps
  Tutte,         ///< tutte_map.h: for small or very flat surfaces on which the others fail
};

/// The start's name as users read it: "Automatic", "Brechbuehler", "Harmonic", "Tutte".
std::string nameOf(InitialMap start);

struct RootMapParameters {
  InitialMap initialMap = InitialMap::Automatic;
  double areaWeight = 0.9;  ///< as in area_preserving_map.h
};

struct RootMapResult {
  SphereMap map;
  InitialMap used;        ///< never Automatic
  int repairedFaces = 0;  ///< of the start: flipped before its repair
  int steps = 0;          ///< global steps of the minimisation
  std::string note;       ///< for the log: why another start than the first choice was taken; empty when it was not
};

/// Initial positions, local repair (untangling.h), then the area-preserving map. A start that cannot be made a valid
/// map makes way for the next one, in Automatic's order.
/// Throws ParameterError when areaWeight is outside [0, 1], and MapError, which names the layer, says for each start
/// how many faces stay flipped and what to do, when no start can be made valid.
RootMapResult makeRootMap(const ClosedSurface& surface, const RootMapParameters& parameters = {},
                          const Progress& progress = {});

}  // namespace sphere_propagation
