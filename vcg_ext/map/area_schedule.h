#pragma once
/// The schedule by which the area energy is minimised: one for all maps that are to have given areas.

#include "vcg_ext/base/progress.h"
#include "vcg_ext/map/area_minimiser.h"

namespace sphere_propagation {

/// Minimises the energy with these weights from valid positions. The weight of the shape term begins at `firstShape`
/// and is lowered in stages to the one asked for, so that areas first travel through faces in good shape; then steps
/// are damped less. Every step keeps the map valid.
///
/// positions: #V by 3 unit vectors, admissible (see AreaMinimiser); changed in place. firstShape: 0.3 brings areas home
/// from anywhere; less is quicker where they are nearly there. Returns the number of global steps taken.
int minimiseInStages(AreaMinimiser& minimiser, const AreaEnergyWeights& weights, Points& positions,
                     const Progress& progress = {}, double firstShape = 0.3);

}  // namespace sphere_propagation
