// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Whether the standard deviations of fits are right, asked of the training shapes.
///
/// Some of them, spread over all, are left out one after the other; the model of the others is
/// fitted to each as to a new surface, whose landmarks are known. Where 95 % of the errors, by
/// coordinate, are within 1.96 c standard deviations, c is by how much these are to be larger. It
/// stands for what the posterior does not know of: that misfit is smooth in another degree than
/// assumed, that few shapes tell their variances badly, and closest points that are wrong.

#include "vcg_ext/base/progress.h"
#include "vcg_ext/fitting/fitting_model.h"

namespace sphere_propagation {

struct FitCalibrationParameters {
  FittingModelParameters model = {};  ///< as for the model that is fitted
  bool scales = false;                ///< as ModelFitParameters
  double meanEdge = 0;  ///< of the surface to be fitted; 0: of the landmarks' own mesh
};

/// How many shapes are left out, at most, and how many there must be.
constexpr Eigen::Index mostLeftOut = 6, minShapesToCalibrate = 5;

/// The model of all shapes but one: mean, modes and variances, from the scores. 0 <= left < #K,
/// #K >= 3.
ShapeModel modelWithout(const ShapeModel& model, Eigen::Index left);

/// c, within 0.5 and 4; 1 where there are fewer than minShapesToCalibrate, or no fit comes about.
/// pool: who does the work, with the same result whatever the number of threads.
double fitCalibration(const ShapeModel& model, ThreadPool& pool,
                      const FitCalibrationParameters& parameters = {});

}  // namespace sphere_propagation
