// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The map of the root of a propagation tree, from nothing but its surface.

#include <string>

#include "vcg_ext/base/progress.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

/// Where the minimisation of area distortion starts from. The map that it ends in is much the same
/// from all.
enum class InitialMap {
  Automatic,     ///< Hierarchical, and where that fails Harmonic, Brechbuehler
  Brechbuehler,  ///< brechbuehler_map.h, the paper's
  Harmonic,      ///< harmonic_map.h
  Hierarchical,  ///< hierarchical_map.h: for every shape, and quickest for large ones
};

/// The start's name as users read it: "Automatic", "Brechbuehler", "Harmonic", "Hierarchical".
std::string nameOf(InitialMap start);

struct RootMapParameters {
  InitialMap initialMap = InitialMap::Automatic;
  double areaWeight = 0.9;  ///< as in area_preserving_map.h
  int threads = 0;  ///< 0: as many as the machine runs at once; the map is the same with any number
};

struct RootMapResult {
  MappedSurface map;
  InitialMap used;        ///< never Automatic
  int levels = 0;         ///< of the hierarchy; 1 for the other starts
  int repairedFaces = 0;  ///< of the start: flipped before its repair
  int steps = 0;          ///< global steps of the minimisation on all vertices
  std::string failures;   ///< why another start than the first choice was taken; empty when it was
                          ///< not
};

/// From an initial position on the sphere, where needed repaired locally (untangling.h), to the
/// area-preserving map. A start that cannot be made a valid map makes way: Brechbuehler's and the
/// harmonic one for the hierarchical start. Throws ParameterError when areaWeight is outside [0, 1]
/// or threads below 0, and MapError, which says what went wrong with each start, when none gives a
/// valid map.
RootMapResult makeRootMap(const ClosedSurface& surface, const RootMapParameters& parameters = {},
                          const Progress& progress = {});

}  // namespace sphere_propagation
