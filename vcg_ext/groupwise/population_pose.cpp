// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/groupwise/population_pose.h"

#include "vcg_ext/base/rotation.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

/// Rotation times scale that takes the shape to what it was aligned to.
Eigen::Matrix3d turnOf(const Points& shape, const Points& aligned, Alignment alignment) {
  if (alignment == Alignment::None) return Eigen::Matrix3d::Identity();
  const Points from = shape.rowwise() - shape.colwise().mean(),
               to = aligned.rowwise() - aligned.colwise().mean();
  const double scale = alignment == Alignment::Similarity ? to.norm() / from.norm() : 1;
  return scale * bestRotation(to.transpose() * from);
}

}  // namespace

double PopulationPose::variance() const {
  double sum = 0;
  for (const Points& shape : shapes) sum += (shape - mean).rowwise().squaredNorm().dot(weights);
  return sum / static_cast<double>(shapes.size());
}

PopulationPose poseOf(const std::vector<Points>& landmarks, const Triangles& faces,
                      Alignment alignment) {
  ProcrustesParameters parameters;
  parameters.alignment = alignment;
  parameters.areaWeights = true;
  parameters.tolerance = 1e-8;
  parameters.iterations = 100;
  std::vector<TrainingSet::Shape> named;
  named.reserve(landmarks.size());
  for (const Points& shape : landmarks) named.push_back({"", shape});
  Aligned aligned = alignShapes(TrainingSet(std::move(named), faces), parameters);
  PopulationPose pose;
  pose.mean = std::move(aligned.mean);
  pose.weights = Eigen::VectorXd::Zero(pose.mean.rows());
  for (size_t k = 0; k < landmarks.size(); ++k) {
    const Points& shape = aligned.shapes.shapes()[k].landmarks;
    pose.turns.push_back(turnOf(landmarks[k], shape, alignment));
    pose.weights += vertexAreas(shape, faces);
    pose.shapes.push_back(shape);
  }
  pose.weights /= pose.weights.sum();
  return pose;
}

}  // namespace sphere_propagation
