// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/surface_geometry.h"

#include <Eigen/Geometry>
#include <cmath>

namespace sphere_propagation {
namespace {

// Areas of very small or large meshes have squares beyond the range of numbers: hence stableNorm.

Vector3 corner(const Points& vertices, const Triangles& faces, Eigen::Index f, int k) {
  return vertices.row(faces(f, k)).transpose();
}

/// Normal of face f, as long as twice its area.
Vector3 areaNormal(const Points& vertices, const Triangles& faces, Eigen::Index f) {
  const Vector3 a = corner(vertices, faces, f, 0);
  return (corner(vertices, faces, f, 1) - a).cross(corner(vertices, faces, f, 2) - a);
}

void normaliseRows(Points& rows) {
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const double length = rows.row(i).stableNorm();
    if (length > 0) rows.row(i) /= length;
  }
}

}  // namespace

Eigen::VectorXd faceAreas(const Points& vertices, const Triangles& faces) {
  Eigen::VectorXd areas(faces.rows());
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    areas[f] = 0.5 * areaNormal(vertices, faces, f).stableNorm();
  return areas;
}

double radiusOfSphere(double area) { return std::sqrt(area / (4 * pi)); }

Eigen::VectorXd vertexAreas(const Points& vertices, const Triangles& faces) {
  const Eigen::VectorXd areas = faceAreas(vertices, faces);
  Eigen::VectorXd shares = Eigen::VectorXd::Zero(vertices.rows());
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) shares[faces(f, k)] += areas[f] / 3;
  return shares;
}

Points faceNormals(const Points& vertices, const Triangles& faces) {
  Points normals(faces.rows(), 3);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    normals.row(f) = areaNormal(vertices, faces, f).transpose();
  normaliseRows(normals);
  return normals;
}

Points vertexNormals(const Points& vertices, const Triangles& faces) {
  Points normals = Points::Zero(vertices.rows(), 3);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const Vector3 n = areaNormal(vertices, faces, f);
    for (int k = 0; k < 3; ++k) normals.row(faces(f, k)) += n.transpose();
  }
  normaliseRows(normals);
  return normals;
}

double meanEdgeLength(const Points& vertices, const Triangles& faces) {
  double sum = 0;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      sum += (corner(vertices, faces, f, k) - corner(vertices, faces, f, (k + 1) % 3)).norm();
  return sum / static_cast<double>(3 * faces.rows());
}

Points cornerAngles(const Points& vertices, const Triangles& faces) {
  Points angles(faces.rows(), 3);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Vector3 p = corner(vertices, faces, f, k);
      const Vector3 a = corner(vertices, faces, f, (k + 1) % 3) - p,
                    b = corner(vertices, faces, f, (k + 2) % 3) - p;
      angles(f, k) = std::atan2(a.cross(b).stableNorm(), a.dot(b));
    }
  return angles;
}

double enclosedVolume(const Points& vertices, const Triangles& faces) {
  const Vector3 centre = vertices.colwise().mean();  // near the mesh, so that little cancels
  double volume = 0;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    volume += areaNormal(vertices, faces, f).dot(corner(vertices, faces, f, 0) - centre) / 6;
  return volume;
}

}  // namespace sphere_propagation
