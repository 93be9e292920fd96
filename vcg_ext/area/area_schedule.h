// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The schedule by which the area energy is minimised: one for all maps that are to have given
/// areas.

#include "vcg_ext/area/area_minimiser.h"
#include "vcg_ext/base/progress.h"

namespace sphere_propagation {

/// Where the shape term begins, and which step ends a stage: the first that leaves this share of
/// the energy or more. The defaults bring areas home from anywhere; a map that has most of its
/// areas already takes less of everything.
struct AreaSchedule {
  double firstShape = 3;     ///< weight of the shape term in the first stage
  double onTheWay = 0.99;    ///< ends a stage
  double atTheEnd = 0.9995;  ///< ends the last one
  int conjugateGradientIterations = 100;
};

/// The least weight of the shape term that is felt beside an area term of 1: it keeps faces from
/// degenerating while areas travel, and is far below what can be seen in the areas.
constexpr double minShapeWeight = 1e-6;

/// Minimises the energy with these weights from valid positions. The weight of the shape term
/// begins at `firstShape` and is lowered in stages to the one asked for (0 follows minShapeWeight),
/// so that areas first travel through faces in good shape; then steps are damped less. Every step
/// keeps the map valid.
///
/// positions: #V by 3 unit vectors, admissible (see AreaMinimiser); changed in place. Returns the
/// number of global steps taken.
int minimiseInStages(AreaMinimiser& minimiser, const AreaEnergyWeights& weights, Points& positions,
                     const Progress& progress = {}, const AreaSchedule& schedule = {});

}  // namespace sphere_propagation
