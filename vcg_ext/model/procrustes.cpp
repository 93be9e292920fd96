// SPDX-License-Identifier: GPL-3.0-only
// Every round starts from the shapes as they came, so that rounding does not add up.

#include "vcg_ext/model/procrustes.h"

#include <algorithm>
#include <cmath>
#include <string>
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

void requireValid(const ProcrustesParameters& parameters) {
  requireRange("tolerance of the alignment", parameters.tolerance, Range::above(0));
  requireRange("number of alignment iterations", parameters.iterations, Range::atLeast(1));
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

/// x -> scale rotation (x - centroid) + place.
struct PlacedFit {
  Fit fit;
  RowVector place = RowVector::Zero();
  Points of(const Points& points) const { return moved(points, fit).rowwise() + place; }
};

/// shared: of a shape and of the mean.
PlacedFit fitShared(const SharedPoints& shared, bool scaled) {
  const Eigen::VectorXd equal = Eigen::VectorXd::Ones(shared.count());
  PlacedFit result;
  result.place = centroid(shared.second, equal);
  result.fit = fit(shared.first, shared.second.rowwise() - result.place, equal, scaled);
  return result;
}

/// The average of what there is of each anchor; NaN where there is nothing.
Points averageOfThere(const std::vector<Points>& anchors, const std::vector<PlacedFit>& fits,
                      const std::vector<char>& isIn) {
  Points sum = Points::Zero(anchors.front().rows(), 3);
  Eigen::VectorXd count = Eigen::VectorXd::Zero(sum.rows());
  for (size_t i = 0; i < anchors.size(); ++i) {
    if (!isIn[i]) continue;
    const Points there = fits[i].of(anchors[i]);
    for (Eigen::Index k = 0; k < sum.rows(); ++k)
      if (anchors[i].row(k).allFinite()) sum.row(k) += there.row(k), ++count[k];
  }
  return (sum.array().colwise() / count.array()).matrix();
}

Points withoutMissing(const Points& points) { return SharedPoints(points, points).first; }

/// Without those that one shape alone has: they say nothing, and would keep it where it is.
std::vector<Points> thoseOfSeveral(std::vector<Points> anchors) {
  for (Eigen::Index k = 0; k < anchors.front().rows(); ++k) {
    const auto there = std::count_if(anchors.begin(), anchors.end(), [k](const Points& ofShape) {
      return ofShape.row(k).allFinite();
    });
    if (there > 1) continue;
    for (Points& ofShape : anchors) ofShape.row(k).setConstant(std::nan(""));
  }
  return anchors;
}

}  // namespace

Aligned alignByAnchors(const TrainingSet& shapes, const std::vector<Points>& allAnchors,
                       bool scaled, const ProcrustesParameters& parameters) {
  requireValid(parameters);
  const std::vector<TrainingSet::Shape>& given = shapes.shapes();
  if (allAnchors.size() != given.size())
    throw ArgumentError("There are anchors of " + std::to_string(allAnchors.size()) +
                        " shapes, but " + std::to_string(given.size()) + " shapes.");
  for (const Points& ofShape : allAnchors)
    if (ofShape.rows() != allAnchors.front().rows())
      throw ArgumentError("Anchors that a shape lacks need rows of their own.");
  if (scaled) requireSize(shapes);
  const std::vector<Points> anchors = thoseOfSeveral(allAnchors);
  size_t first = 0;
  for (size_t i = 1; i < anchors.size(); ++i)
    if (withoutMissing(anchors[i]).rows() > withoutMissing(anchors[first]).rows()) first = i;
  std::vector<PlacedFit> fits(given.size());
  fits[first].fit = {RowVector::Zero(), Eigen::Matrix3d::Identity(), 1};
  std::vector<char> isIn(given.size(), 0);
  Points mean = anchors[first];
  isIn[first] = 1;

  // Who has a pose gives a mean to those who share anchors with him.
  for (bool joined = true; joined;) {
    joined = false;
    for (size_t i = 0; i < given.size(); ++i) {
      const SharedPoints shared(anchors[i], mean);
      if (isIn[i] || !shared.fixPose()) continue;
      fits[i] = fitShared(shared, scaled);
      isIn[i] = joined = true;
    }
    mean = averageOfThere(anchors, fits, isIn);
  }
  for (size_t i = 0; i < given.size(); ++i) {
    const SharedPoints shared(anchors[i], mean);
    if (isIn[i] && shared.fixPose()) continue;
    throw ParameterError(
        Finding(shared.count() < minPosePoints ? Fault::FewSharedAnchors : Fault::AnchorsOnOneLine,
                given[i].name)
            .of(shared.count()));
  }

  const auto sizeOf = [](const Points& points) {
    const Points there = withoutMissing(points);
    return centroidSize(there, Eigen::VectorXd::Ones(there.rows()));
  };
  const double startSize = sizeOf(mean);
  int iterations = 0;
  bool converged = false;
  while (!converged && iterations < parameters.iterations) {
    for (size_t i = 0; i < given.size(); ++i)
      fits[i] = fitShared(SharedPoints(anchors[i], mean), scaled);
    Points next = averageOfThere(anchors, fits, isIn);
    if (scaled) {  // about its own middle: about the origin it would wander off, round by round
      const RowVector middle = withoutMissing(next).colwise().mean();
      next = ((startSize / sizeOf(next)) * (next.rowwise() - middle)).rowwise() + middle;
    }
    const double change = withoutMissing(next - mean).norm();
    mean = std::move(next);
    ++iterations;
    converged = change <= parameters.tolerance * startSize;
  }

  // Into the frame of the first shape, as it lies.
  const PlacedFit frame = fits.front();
  std::vector<TrainingSet::Shape> result = given;
  double sizes = 0;
  const Eigen::VectorXd equal = Eigen::VectorXd::Ones(shapes.landmarkCount());
  for (size_t i = 0; i < given.size(); ++i) {
    sizes += centroidSize(given[i].landmarks, equal);
    result[i].landmarks =
        ((fits[i].of(given[i].landmarks).rowwise() - frame.place) * frame.fit.rotation) /
        frame.fit.scale;
    result[i].landmarks.rowwise() += frame.fit.centroid;
  }
  if (scaled) {
    const double unit =
        sizes / static_cast<double>(given.size()) / centroidSize(average(result), equal);
    const RowVector middle = centroid(result.front().landmarks, equal);
    for (TrainingSet::Shape& shape : result)
      shape.landmarks = (unit * (shape.landmarks.rowwise() - middle)).rowwise() + middle;
  }
  const Points mean0 = average(result);
  return {TrainingSet(std::move(result), shapes.faces(), shapes.leftOut()), mean0, iterations,
          converged};
}

Aligned alignShapes(const TrainingSet& shapes, const ProcrustesParameters& parameters) {
  requireValid(parameters);
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
