// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/fitting/fit_calibration.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/statistics.h"
#include "vcg_ext/fitting/model_fit.h"
#include "vcg_ext/model/thin_svd.h"

namespace sphere_propagation {
namespace {

constexpr int calibrationIterations = 6;
constexpr Eigen::Index observedLandmarks = 200;  // of each; the samples are thinned alike
constexpr double coverage = 0.95, deviationsOfCoverage = 1.96;
constexpr double leastFactor = 0.5, mostFactor = 4;

/// |error| over its standard deviation, by coordinate. Empty where the fit goes astray.
std::vector<double> standardErrors(const ShapeModel& model, Eigen::Index left,
                                   const FitCalibrationParameters& parameters) {
  ThreadPool own(1);
  const Points truth = model.shape(Eigen::VectorXd(model.scores.row(left).transpose()));
  std::vector<double> errors;
  try {
    const FittingModel others(modelWithout(model, left), own, parameters.model);
    const FittingTarget target(truth, model.faces);
    ModelFitParameters search;
    search.scales = parameters.scales;
    search.iterations = calibrationIterations;
    search.meanEdge = parameters.meanEdge;
    search.thinning = static_cast<int>(std::max<Eigen::Index>(1, truth.rows() / observedLandmarks));
    const ModelFit fit = fitModel(others, target, own, search);
    for (Eigen::Index j = 0; j < truth.rows(); j += search.thinning)
      for (int axis = 0; axis < 3; ++axis) {
        const double variance = fit.covariance[static_cast<size_t>(j)](axis, axis);
        if (variance > 0)
          errors.push_back(std::fabs(fit.landmarks(j, axis) - truth(j, axis)) /
                           std::sqrt(variance));
      }
  } catch (const Error&) {
    errors.clear();
  }
  return errors;
}

}  // namespace

ShapeModel modelWithout(const ShapeModel& model, Eigen::Index left) {
  const Eigen::Index shapes = model.scores.rows(), modes = model.modes.cols();
  Eigen::MatrixXd others(shapes - 1, modes);
  others.topRows(left) = model.scores.topRows(left).leftCols(modes);
  others.bottomRows(shapes - 1 - left) = model.scores.bottomRows(shapes - 1 - left).leftCols(modes);
  const Eigen::VectorXd middle = others.colwise().mean().transpose();
  others.rowwise() -= middle.transpose();
  constexpr double nothing = 1e-9;
  ThreadPool own(1);
  const ThinSvd svd = thinSvd(others.transpose(), nothing * others.norm(), modes, own);
  const Eigen::VectorXd& s = svd.s;
  const Eigen::Index count = std::min(s.size(), shapes - 2);
  ShapeModel without;
  without.mean = model.shape(middle);
  without.faces = model.faces;
  without.modes = model.modes * svd.u.leftCols(count);
  without.eigenvalues = s.head(count).cwiseAbs2() / static_cast<double>(shapes - 2);
  without.scores = svd.v.leftCols(count) * s.head(count).asDiagonal();
  without.totalVariance = without.eigenvalues.sum();
  return without;
}

double fitCalibration(const ShapeModel& model, ThreadPool& pool,
                      const FitCalibrationParameters& parameters) {
  const Eigen::Index shapes = model.scores.rows();
  if (shapes < minShapesToCalibrate || model.modes.cols() == 0) return 1;
  const auto count = static_cast<int>(std::min(shapes, mostLeftOut));
  const std::vector<std::vector<double>> each = pool.makeEach(count, [&](int i) {
    return standardErrors(model, (2 * i + 1) * shapes / (2 * count), parameters);
  });
  std::vector<double> all;
  for (const std::vector<double>& errors : each)
    all.insert(all.end(), errors.begin(), errors.end());
  if (all.empty()) return 1;
  return std::clamp(lowerQuantileOf(std::move(all), coverage) / deviationsOfCoverage, leastFactor,
                    mostFactor);
}

}  // namespace sphere_propagation
