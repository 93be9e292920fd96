// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// How good a shape model is, as functions of the number of modes: compactness, generalisation,
/// specificity. R. H. Davies, Learning shape: optimal models for analysing natural variability,
/// 2002; M. A. Styner, K. T. Rajamani, L.-P. Nolte, G. Zsemlye, G. Szekely, C. J. Taylor and R. H.
/// Davies, Evaluation of 3D correspondence methods for model building, 2003.

#include "vcg_ext/base/progress.h"
#include "vcg_ext/model/shape_model.h"

namespace sphere_propagation {

struct ModelMeasureParameters {
  static constexpr int maxSamples = 1'000'000;

  int samples = 1000;  ///< shapes drawn for the specificity, 1 to maxSamples
  unsigned seed = 0;   ///< of the draws: the same seed, the same samples on every machine (but for
                       ///< the last digits)
  int threads = 0;  ///< 0: as many as the machine runs at once; the figures are the same with any
};

/// Entry m - 1 is for the model with m modes. d(x, y) = sqrt(1/#N sum_j |x_j - y_j|^2): the root
/// mean square distance of corresponding landmarks, in the unit of length.
struct ModelMeasures {
  /// C(m) = sum of the first m eigenvalues: unit of length squared.
  Eigen::VectorXd compactness;
  /// G(m) = 1/#K sum_i d(x_i, x'_i(m)), x'_i(m) the best approximation of x_i by the first m modes
  /// of the model of all other shapes. That one has #K - 2 modes at most; where it has fewer than
  /// m, all are used.
  Eigen::VectorXd generalisation;
  /// S(m) = mean over samples y = mean + sum_{l <= m} sqrt(eigenvalue_l) g_l mode_l, g_l standard
  /// normal, of min_i d(y, x_i), the distance to the nearest training shape.
  Eigen::VectorXd specificity;
  /// Standard errors of the two means: standard deviation / sqrt(count - 1).
  Eigen::VectorXd generalisationError, specificityError;
};

/// Measures the models of 1 to `modes` modes. The shapes stay as they were aligned once for all:
/// they are not aligned again when one is left out. Nothing is lost by working on the scores, which
/// hold all distances between shapes. O(#K #M) for each of the modes, and for each sample.
///
/// model: with all its scores, as buildShapeModel makes it; modes: at most those of the model
/// count. Throws ParameterError when a parameter is out of range.
ModelMeasures measureModel(const ShapeModel& model, Eigen::Index modes,
                           const ModelMeasureParameters& parameters = {},
                           const Progress& progress = {});

}  // namespace sphere_propagation
