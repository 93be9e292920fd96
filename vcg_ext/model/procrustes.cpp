// SPDX-License-Identifier: GPL-3.0-only
// Every round starts from the shapes as they came, so that rounding does not add up.

#include "vcg_ext/model/procrustes.h"

#include <cmath>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/rotation.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

using RowVector = Eigen::RowVector3d;

struct Fit {
  RowVector centroid;
  Eigen::Matrix3d rotation;
  double scale = 1;
};

/// Weights with mean 1; a mean without any area has equal ones.
Eigen::VectorXd landmarkWeights(const Points& mean, const Triangles& faces, bool areaWeights) {
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(mean.rows());
  if (!areaWeights) return weights;
  const Eigen::VectorXd areas = vertexAreas(mean, faces);
  const double average = areas.mean();
  if (average > 0) weights = areas / average;
  return weights;
}

RowVector centroid(const Points& points, const Eigen::VectorXd& weights) {
  return weights.transpose() * points / weights.sum();
}

double centroidSize(const Points& points, const Eigen::VectorXd& weights) {
  const Points centred = points.rowwise() - centroid(points, weights);
  return std::sqrt(centred.rowwise().squaredNorm().dot(weights));
}

/// Brings the points closest to a mean whose centroid is the origin.
Fit fit(const Points& points, const Points& mean, const Eigen::VectorXd& weights, bool scaled) {
  Fit result;
  result.centroid = centroid(points, weights);
  const Points centred = points.rowwise() - result.centroid;
  const Eigen::Matrix3d covariance = mean.transpose() * (weights.asDiagonal() * centred);
  result.rotation = bestRotation(covariance);
  if (scaled)
    result.scale = (result.rotation.transpose() * covariance).trace() /
                   centred.rowwise().squaredNorm().dot(weights);
  return result;
}

Points moved(const Points& points, const Fit& fit) {
  return fit.scale * (points.rowwise() - fit.centroid) * fit.rotation.transpose();
}

void requireSize(const TrainingSet& shapes) {
  const Eigen::VectorXd equal = Eigen::VectorXd::Ones(shapes.landmarkCount());
  for (const auto& [name, landmarks] : shapes.shapes())
    if (!(centroidSize(landmarks, equal) > 1e-12 * landmarks.cwiseAbs().maxCoeff()))
      throw ParameterError(Finding(Fault::LandmarksInOnePlace, name).of(shapes.landmarkCount()));
}

Points average(const std::vector<TrainingSet::Shape>& shapes) {
  Points sum = Points::Zero(shapes.front().landmarks.rows(), 3);
  for (const TrainingSet::Shape& shape : shapes) sum += shape.landmarks;
  return sum / static_cast<double>(shapes.size());
}

}  // namespace

Aligned alignShapes(const TrainingSet& shapes, const ProcrustesParameters& parameters) {
  requireRange("tolerance of the alignment", parameters.tolerance, Range::above(0));
  requireRange("number of alignment iterations", parameters.iterations, Range::atLeast(1));
  const std::vector<TrainingSet::Shape>& given = shapes.shapes();
  if (parameters.alignment == Alignment::None) return {shapes, average(given), 0, true};
  const bool scaled = parameters.alignment == Alignment::Similarity;
  if (scaled) requireSize(shapes);

  const auto count = static_cast<double>(given.size());
  std::vector<Fit> fits(given.size());
  Points mean = given.front().landmarks;
  Eigen::VectorXd weights = landmarkWeights(mean, shapes.faces(), parameters.areaWeights);
  mean.rowwise() -= centroid(mean, weights);
  const double startSize = centroidSize(mean, weights);

  int iterations = 0;
  bool converged = false;
  while (!converged && iterations < parameters.iterations) {
    Points next = Points::Zero(mean.rows(), 3);
    for (size_t i = 0; i < given.size(); ++i) {
      fits[i] = fit(given[i].landmarks, mean, weights, scaled);
      next += moved(given[i].landmarks, fits[i]) / count;
    }
    weights = landmarkWeights(next, shapes.faces(), parameters.areaWeights);
    next.rowwise() -= centroid(next, weights);
    if (scaled) next *= startSize / centroidSize(next, weights);
    const double change = (next - mean).norm(), size = next.norm();
    mean = std::move(next);
    ++iterations;
    converged = change <= parameters.tolerance * size;
  }

  // Into the frame of the first shape, the average at the average size.
  const Fit first = fits.front();
  std::vector<TrainingSet::Shape> result = given;
  double sizes = 0;
  for (size_t i = 0; i < given.size(); ++i) {
    sizes += centroidSize(given[i].landmarks, weights);
    fits[i].rotation = first.rotation.transpose() * fits[i].rotation;
    result[i].landmarks = moved(given[i].landmarks, fits[i]);
  }
  if (scaled) {
    const double unit = sizes / count / centroidSize(average(result), weights);
    for (TrainingSet::Shape& shape : result) shape.landmarks *= unit;
  }
  for (TrainingSet::Shape& shape : result) shape.landmarks.rowwise() += first.centroid;
  const Points mean0 = average(result);
  return {TrainingSet(std::move(result), shapes.faces(), shapes.leftOut()), mean0, iterations,
          converged};
}

}  // namespace sphere_propagation
