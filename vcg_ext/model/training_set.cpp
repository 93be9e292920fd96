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

TrainingSet::TrainingSet(std::vector<Shape> shapes, Triangles faces)
    : shapes_(std::move(shapes)), faces_(std::move(faces)) {
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

}  // namespace sphere_propagation
