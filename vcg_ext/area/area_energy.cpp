// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/area/area_energy.h"

#include <algorithm>

#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/mesh/usable_extent.h"

namespace sphere_propagation {
namespace {

constexpr double equilateralCotangent = 0.57735026918962576;

}  // namespace

std::array<float, 3> faceStiffness(const std::array<Vector3, 3>& p, const ShapeTrust& trust) {
  std::array<double, 3> squared{};  // length of the edge opposite each corner
  for (int k = 0; k < 3; ++k) squared[k] = (p[(k + 1) % 3] - p[(k + 2) % 3]).squaredNorm();
  const double sum = squared[0] + squared[1] + squared[2];
  const double area =
      std::max(0.5 * (p[1] - p[0]).cross(p[2] - p[0]).norm(), trust.minFlatness * sum);
  std::array<float, 3> stiffness{};
  for (int k = 0; k < 3; ++k) {
    const double cotangent = area > 0 ? (sum - 2 * squared[k]) / (4 * area) : equilateralCotangent;
    stiffness[k] = static_cast<float>((1 - trust.equilateralShare) * cotangent +
                                      trust.equilateralShare * equilateralCotangent);
  }
  return stiffness;
}

std::vector<FaceTarget> faceTargets(const Points& vertices, const Triangles& faces,
                                    const ShapeTrust& trust) {
  Eigen::VectorXd areas = faceAreas(vertices, faces);
  areas = areas.cwiseMax(minFaceShare * areas.mean());
  areas *= 4 * pi / areas.sum();
  const double mean = areas.mean();
  // Neither tiny nor huge coordinates shall leave the range of numbers.
  const double extent = (vertices.colwise().maxCoeff() - vertices.colwise().minCoeff()).maxCoeff();
  std::vector<FaceTarget> targets(static_cast<size_t>(faces.rows()));
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    std::array<Vector3, 3> p;
    for (int k = 0; k < 3; ++k) p[k] = vertices.row(faces(f, k)).transpose() / extent;
    targets[static_cast<size_t>(f)] = {areas[f], mean, faceStiffness(p, trust)};
  }
  return targets;
}

}  // namespace sphere_propagation
