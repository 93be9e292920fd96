// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/groupwise/surface_landmarks.h"

#include <Eigen/Geometry>

#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {

LandmarkReader::LandmarkReader(const MappedSurface& surface)
    : surface_(surface),
      normals_(vertexNormals(surface.surface().vertices(), surface.faces())),
      walk_(surface) {}

// The point under u is sum w_i p_i / sum w_i with w_i = u . (b x c) and so on, which is linear in
// u.
SurfaceLandmarks LandmarkReader::read(const Points& directions) {
  const Eigen::Index count = directions.rows();
  SurfaceLandmarks found{Points(count, 3), Points(count, 3), {}};
  found.derivatives.reserve(static_cast<size_t>(count));
  for (Eigen::Index j = 0; j < count; ++j) {
    const Vector3 u = directions.row(j).transpose();
    const SurfacePoint at = walk_.locate(u);
    const auto corner = [&](int k) { return surface_.faces()(at.face, k % 3); };
    Vector3 point = Vector3::Zero(), normal = Vector3::Zero();
    for (int k = 0; k < 3; ++k) {
      point += at.weights[k] * surface_.surface().vertex(corner(k));
      normal += at.weights[k] * normals_.row(corner(k)).transpose();
    }
    Eigen::Matrix3d derivative = Eigen::Matrix3d::Zero();
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
      const Vector3 across =
          surface_.position(corner(k + 1)).cross(surface_.position(corner(k + 2)));
      sum += across.dot(u);
      derivative += (surface_.surface().vertex(corner(k)) - point) * across.transpose();
    }
    found.points.row(j) = point.transpose();
    found.normals.row(j) = normal.stableNormalized().transpose();
    if (sum > 0)
      found.derivatives.emplace_back(derivative / sum);
    else
      found.derivatives.emplace_back(Eigen::Matrix3d::Zero());  // a face without extent
  }
  return found;
}

}  // namespace sphere_propagation
