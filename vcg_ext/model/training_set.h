// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The shapes that a model is built from. Correspondence is a property of the type: whatever takes
/// a TrainingSet need not check again that landmark j is there on every shape.

#include <string>
#include <vector>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

class TrainingSet {
 public:
  struct Shape {
    std::string name;  ///< what errors call it
    Points landmarks;  ///< #N by 3
  };

  /// shapes: two or more, with as many landmarks each, at least one, all finite; faces: #F by 3,
  /// common to all; leftOut: what leftOut() returns. Throws ParameterError, which names the shapes
  /// concerned.
  TrainingSet(std::vector<Shape> shapes, Triangles faces, std::vector<char> leftOut = {});

  /// The same without some landmarks and without the faces that use one of them. leave: #N, true
  /// where a landmark goes. Throws ParameterError where none is left.
  TrainingSet without(const std::vector<char>& leave) const;

  const std::vector<Shape>& shapes() const { return shapes_; }
  const Triangles& faces() const { return faces_; }
  /// One entry per landmark that there was before `without`, true where it went: landmark j of the
  /// set is the j-th false one. Empty: none went.
  const std::vector<char>& leftOut() const { return leftOut_; }
  Eigen::Index shapeCount() const { return static_cast<Eigen::Index>(shapes_.size()); }
  Eigen::Index landmarkCount() const { return shapes_.front().landmarks.rows(); }

 private:
  std::vector<Shape> shapes_;
  Triangles faces_;
  std::vector<char> leftOut_;
};

}  // namespace sphere_propagation
