// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Sets of corresponding shapes for the tests of the shape model.

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tests/core/test_meshes.h"
#include "vcg_ext/model/shape_model.h"
#include "vcg_ext/model/training_set.h"

namespace sphere_propagation::test {

inline TrainingSet trainingSet(const std::vector<Points>& shapes, const Triangles& faces) {
  std::vector<TrainingSet::Shape> named;
  for (size_t k = 0; k < shapes.size(); ++k)
    named.push_back({"shape " + std::to_string(k), shapes[k]});
  return {std::move(named), faces};
}

/// Ellipsoids of 162 landmarks with random axes about (30, 20, 15) and a little noise, all in one
/// pose.
inline std::vector<Points> ellipsoids(int count, unsigned seed, double noise = 0.2) {
  Random random(seed);
  const Mesh sphere = icosphereMesh(4);
  std::vector<Points> shapes;
  for (int k = 0; k < count; ++k) {
    const Mesh mesh = stretched(sphere, 30 + 2 * random.normal(), 20 + 2 * random.normal(),
                                15 + 1 * random.normal());
    Points points = mesh.vertices;
    for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] += noise * random.normal();
    shapes.push_back(points);
  }
  return shapes;
}

inline Triangles ellipsoidFaces() { return icosphereMesh(4).faces; }

/// The model of `ellipsoids`.
inline ShapeModel modelOf(const std::vector<Points>& shapes) {
  return buildShapeModel(trainingSet(shapes, ellipsoidFaces()));
}

inline double largestDifference(const Points& a, const Points& b) {
  return (a - b).cwiseAbs().maxCoeff();
}

inline Points moved(const Points& points, const Eigen::Matrix3d& rotation, double scale,
                    const Vector3& translation) {
  return (scale * points * rotation.transpose()).rowwise() + translation.transpose();
}

/// A unit displacement of all landmarks (3 #N entries), random.
inline Points randomDirection(Eigen::Index landmarks, unsigned seed) {
  Random random(seed);
  Points direction(landmarks, 3);
  for (Eigen::Index i = 0; i < direction.size(); ++i) direction.data()[i] = random.normal();
  return direction / direction.norm();
}

}  // namespace sphere_propagation::test
