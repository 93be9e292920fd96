#include "vcg_ext/map/texture_copy.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vcg_ext/map/certificate.h"
#include "vcg_ext/map/sphere_coordinates.h"
#include "vcg_ext/map/spherical_triangle.h"

namespace sphere_propagation {
namespace {

/// The smallest solid angle of the faces around vertex v if it were at p.
double leastSolidAngleAround(const ClosedSurface& surface, const Points& positions, int v, const Vector3& p) {
  double least = std::numeric_limits<double>::infinity();
  const IndexRange ring = surface.ring(v);
  for (int i = 0; i < ring.size(); ++i) {
    const Vector3 b = positions.row(ring[i]).transpose();
    const Vector3 c = positions.row(ring[(i + 1) % ring.size()]).transpose();
    least = std::min(least, solidAngle(p, b, c));
  }
  return least;
}

float shifted(float x, int steps) {
  for (; steps > 0; --steps) x = std::nextafter(x, 2.0F);
  for (; steps < 0; ++steps) x = std::nextafter(x, -1.0F);
  return x;
}

/// Moves vertex v to the float coordinates within a few steps that leave its smallest face largest.
bool moveToBestNeighbour(const ClosedSurface& surface, int v, TextureCopy& copy, Points& positions) {
  constexpr int reach = 3;
  const float u0 = copy.coordinates(v, 0), v0 = copy.coordinates(v, 1);
  double best = leastSolidAngleAround(surface, positions, v, positions.row(v).transpose());
  bool moved = false;
  for (int i = -reach; i <= reach; ++i)
    for (int j = -reach; j <= reach; ++j) {
      const float a = shifted(u0, i), b = shifted(v0, j);
      if (a < 0 || a > 1 || b < 0 || b > 1) continue;
      const Vector3 p = spherePosition({a, b});
      const double least = leastSolidAngleAround(surface, positions, v, p);
      if (least <= best) continue;
      best = least;
      moved = true;
      copy.coordinates.row(v) << a, b;
      positions.row(v) = p.transpose();
    }
  return moved;
}

}  // namespace

Points positionsFromTexture(const Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor>& coordinates) {
  Points positions(coordinates.rows(), 3);
  for (Eigen::Index v = 0; v < coordinates.rows(); ++v)
    positions.row(v) = spherePosition(coordinates.row(v).transpose().cast<double>()).transpose();
  return positions;
}

TextureCopy copyToTexture(const ClosedSurface& surface, const SphereMap& map) {
  TextureCopy copy;
  copy.coordinates.resize(surface.vertexCount(), 2);
  for (int v = 0; v < surface.vertexCount(); ++v)
    copy.coordinates.row(v) = textureCoordinate(map.position(v)).cast<float>().transpose();
  Points positions = positionsFromTexture(copy.coordinates);
  constexpr int rounds = 5;
  for (int round = 0; round < rounds; ++round) {
    copy.valid = certify(surface.faces(), positions).valid();
    if (copy.valid) break;
    for (int f = 0; f < surface.faceCount(); ++f) {
      const auto corner = [&](int k) { return surface.faces()(f, k); };
      const auto at = [&](int k) { return Vector3(positions.row(corner(k)).transpose()); };
      if (solidAngle(at(0), at(1), at(2)) >= Certificate::leastSolidAngle) continue;
      for (int k = 0; k < 3; ++k) copy.mendedVertices += moveToBestNeighbour(surface, corner(k), copy, positions);
    }
  }
  if (!copy.valid) copy.valid = certify(surface.faces(), positions).valid();
  return copy;
}

}  // namespace sphere_propagation
