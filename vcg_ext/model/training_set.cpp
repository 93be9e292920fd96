// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/training_set.h"

#include <utility>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

void requireFinite(const TrainingSet::Shape& shape) {
  long count = 0;
  Eigen::Index first = -1;
  for (Eigen::Index j = 0; j < shape.landmarks.rows(); ++j)
    if (!shape.landmarks.row(j).allFinite() && count++ == 0) first = j;
  if (count > 0)
    throw ParameterError(Finding(Fault::NonFiniteLandmark, shape.name).of(count, first));
}

}  // namespace

TrainingSet::TrainingSet(std::vector<Shape> shapes, Triangles faces, std::vector<char> leftOut)
    : shapes_(std::move(shapes)), faces_(std::move(faces)), leftOut_(std::move(leftOut)) {
  if (shapes_.empty()) throw ArgumentError("There is no shape to make a model of.");
  const Shape& first = shapes_.front();
  if (shapes_.size() < 2) throw ParameterError(Finding(Fault::TooFewShapes, first.name).of(1));
  if (first.landmarks.rows() == 0) throw ParameterError(Finding(Fault::NoLandmarks, first.name));
  for (const Shape& shape : shapes_) {
    if (shape.landmarks.rows() != first.landmarks.rows())
      throw ParameterError(Finding(Fault::LandmarkCount, first.name)
                               .against(shape.name)
                               .of(first.landmarks.rows())
                               .amid(shape.landmarks.rows()));
    requireFinite(shape);
  }
  for (Eigen::Index f = 0; f < faces_.rows(); ++f)
    if (faces_.row(f).minCoeff() < 0 || faces_.row(f).maxCoeff() >= first.landmarks.rows())
      throw ArgumentError("Face " + std::to_string(f) +
                          " refers to a landmark that is not there; there are " +
                          std::to_string(first.landmarks.rows()) + ".");
}

TrainingSet TrainingSet::without(const std::vector<char>& leave) const {
  std::vector<int> now(leave.size(), -1), kept;
  for (size_t j = 0; j < leave.size(); ++j) {
    if (leave[j]) continue;
    now[j] = static_cast<int>(kept.size());
    kept.push_back(static_cast<int>(j));
  }
  std::vector<Shape> shapes;
  for (const auto& [name, landmarks] : shapes_) {
    Points some(static_cast<Eigen::Index>(kept.size()), 3);
    for (size_t j = 0; j < kept.size(); ++j)
      some.row(static_cast<Eigen::Index>(j)) = landmarks.row(kept[j]);
    shapes.push_back({name, std::move(some)});
  }
  Triangles faces(faces_.rows(), 3);
  Eigen::Index count = 0;
  for (Eigen::Index f = 0; f < faces_.rows(); ++f) {
    for (int k = 0; k < 3; ++k) faces(count, k) = now[static_cast<size_t>(faces_(f, k))];
    if (faces.row(count).minCoeff() >= 0) ++count;
  }
  faces.conservativeResize(count, 3);
  std::vector<char> leftOut = leftOut_.empty() ? std::vector<char>(leave.size(), 0) : leftOut_;
  size_t j = 0;
  for (char& out : leftOut)
    if (!out) out = leave[j++];
  return {std::move(shapes), std::move(faces), std::move(leftOut)};
}

}  // namespace sphere_propagation
