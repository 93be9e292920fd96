// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Whether a surface looks like a mirror image of what a model shows.

#include "vcg_ext/fitting/model_fit.h"

namespace sphere_propagation {

/// How much more likely the surface's mirror image is under the model than the surface: the
/// difference of the logarithms of both posteriors, each at its best pose. The surface's is where
/// `fit` brought it, the mirror image's is searched for from fewer poses, so a doubt speaks for the
/// surface. Both are fitted anew to a part of the landmarks and samples, without anchors, which no
/// mirror image has. scales: as in the fit. Minus infinity where the mirror image fits nowhere.
double advantageOfMirrorImage(const FittingModel& model, const FittingTarget& target,
                              const ModelFit& fit, bool scales, ThreadPool& pool);

/// Above it, the surface is named. Hearts, hippocampi and walls of the heart were at -5 and below
/// where they were right, and above 6 as mirror images; skulls, which are nearly their own, between
/// -8 and 8 either way (docs/fitting.md).
constexpr double clearAdvantage = 10;

}  // namespace sphere_propagation
