// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A map for the surface that a model was fitted to, so that it has landmarks of its own, like any
/// surface of the training set.

#include "vcg_ext/base/progress.h"
#include "vcg_ext/fitting/model_fit.h"
#include "vcg_ext/propagation/propagation.h"

namespace sphere_propagation {

/// Whether the model's landmarks are an icosphere's, all of them, so that they have a map: none has
/// a model that leaves lids out.
bool hasMap(const FittingModel& model);

/// The fitted landmarks, with the map that the icosphere gives them, are propagated onto the
/// surface (PropagationMethod::Robust), which they lie on but for what the model cannot show. fit:
/// of this model to this surface. threads: as PropagationParameters. Throws ParameterError where
/// the model has no map, SurfaceError where the fitted landmarks are no surface, and as propagate
/// does.
PropagatedLayer mapOfFit(const FittingModel& model, const ModelFit& fit,
                         const ClosedSurface& surface, int threads = 0,
                         const Progress& progress = {});

}  // namespace sphere_propagation
