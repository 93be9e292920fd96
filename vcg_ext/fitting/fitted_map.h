// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A map for the surface that a model was fitted to, so that it has landmarks of its own, like any
/// surface of the training set.

#include "vcg_ext/base/progress.h"
#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/fitting/model_fit.h"
#include "vcg_ext/propagation/propagation.h"

namespace sphere_propagation {

/// Whether the model's landmarks can have a map: they are an icosphere's, all of them, or the mean
/// is some other closed surface of genus 0. A model that leaves lids out has none.
bool hasMap(const FittingModel& model);

/// The fitted landmarks, with the map that the icosphere gives them, or else the area-preserving
/// map of the mean (root_map.h), are propagated onto the surface (PropagationMethod::Robust), which
/// they lie on but for what the model cannot show. fit: of this model to this surface. pool: who
/// does the work, with the same result whatever the number of threads. Throws ParameterError where
/// the model has no map, SurfaceError where the fitted landmarks are no surface, MapError where the
/// mean gets no map, and as propagate does.
PropagatedLayer mapOfFit(const FittingModel& model, const ModelFit& fit,
                         const ClosedSurface& surface, ThreadPool& pool,
                         const Progress& progress = {});

}  // namespace sphere_propagation
