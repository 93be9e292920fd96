// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// From a valid map to an area-preserving one.

#include <vector>

#include "vcg_ext/area/area_energy.h"
#include "vcg_ext/base/progress.h"
#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

struct AreaPreservingParameters {
  /// In [0, 1]. 1: areas alone, as far as validity allows; 0: angles alone. The default all but
  /// preserves area and spends what freedom is left on angles.
  double areaWeight = 0.9;
  std::vector<char> held = {};  ///< #V, 1 for each vertex that stays where it is; empty: none
};

struct AreaPreservingResult {
  MappedSurface map;
  int steps = 0;  ///< global steps taken
};

/// The weights of the energy that stand for an area weight in [0, 1]. Throws ParameterError when it
/// is outside.
AreaEnergyWeights energyWeights(double areaWeight);

/// Minimises the energy of area_energy.h from `start`. The weight of the shape term is lowered in
/// stages to the one that `areaWeight` asks for, so that areas first travel through faces in good
/// shape. Every step keeps the map valid. pool: who does the work, the calling thread alone where
/// there is none; the result is the same. Throws ParameterError when areaWeight is outside [0, 1].
AreaPreservingResult makeAreaPreserving(const MappedSurface& start,
                                        const AreaPreservingParameters& parameters = {},
                                        const Progress& progress = {}, ThreadPool* pool = nullptr);

}  // namespace sphere_propagation
