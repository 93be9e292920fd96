// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/training_set.h"

#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/text.h"

namespace sphere_propagation {
namespace {

std::string quoted(const TrainingSet::Shape& shape) { return "\"" + shape.name + "\""; }

void requireFinite(const TrainingSet::Shape& shape) {
  long count = 0;
  Eigen::Index first = -1;
  for (Eigen::Index j = 0; j < shape.landmarks.rows(); ++j)
    if (!shape.landmarks.row(j).allFinite() && count++ == 0) first = j;
  if (count > 0)
    throw ParameterError("Shape " + quoted(shape) + ": " +
                         counted(count, "landmark has", "landmarks have") +
                         " coordinates that are not finite; the first is landmark " +
                         std::to_string(first) + ". Remesh its surface again, or hide the layer.");
}

}  // namespace

TrainingSet::TrainingSet(std::vector<Shape> shapes, Triangles faces)
    : shapes_(std::move(shapes)), faces_(std::move(faces)) {
  if (shapes_.size() < 2)
    throw ParameterError(
        "A shape model needs at least two shapes; there " +
        (shapes_.empty() ? std::string("is none.") : "is only " + quoted(shapes_.front()) + "."));
  const Shape& first = shapes_.front();
  if (first.landmarks.rows() == 0)
    throw ParameterError("Shape " + quoted(first) + " has no landmarks.");
  for (const Shape& shape : shapes_) {
    if (shape.landmarks.rows() != first.landmarks.rows())
      throw ParameterError("Shapes " + quoted(first) + " and " + quoted(shape) +
                           " do not correspond: they have " +
                           std::to_string(first.landmarks.rows()) + " and " +
                           std::to_string(shape.landmarks.rows()) +
                           " landmarks. Remesh all surfaces with one frequency, or hide the layers "
                           "that do not belong to the model.");
    requireFinite(shape);
  }
  for (Eigen::Index f = 0; f < faces_.rows(); ++f)
    if (faces_.row(f).minCoeff() < 0 || faces_.row(f).maxCoeff() >= first.landmarks.rows())
      throw ParameterError("Face " + std::to_string(f) +
                           " refers to a landmark that is not there; there are " +
                           std::to_string(first.landmarks.rows()) + ".");
}

}  // namespace sphere_propagation
