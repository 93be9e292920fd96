// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/repair/float_copy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "vcg_ext/sphere/certificate.h"
#include "vcg_ext/sphere/sphere_coordinates.h"
#include "vcg_ext/sphere/spherical_triangle.h"

namespace sphere_propagation {
namespace {

/// The smallest solid angle of the faces around vertex v if it were at p.
double minSolidAngleAround(const ClosedSurface& surface, const Points& positions, int v,
                           const Vector3& p) {
  double least = std::numeric_limits<double>::infinity();
  const IndexRange ring = surface.ring(v);
  for (int i = 0; i < ring.size(); ++i) {
    const Vector3 b = positions.row(ring[i]).transpose();
    const Vector3 c = positions.row(ring[(i + 1) % ring.size()]).transpose();
    least = std::min(least, solidAngle(p, b, c));
  }
  return least;
}

bool isTooSmall(const ClosedSurface& surface, const Points& positions, int face) {
  const auto at = [&](int k) {
    return Vector3(positions.row(surface.faces()(face, k)).transpose());
  };
  return solidAngle(at(0), at(1), at(2)) < Certificate::minSolidAngle;
}

/// `around(v, floats)`: the floats that a vertex with these may be moved to, near where it is;
/// `positionOf(floats)`: the position that they stand for.
template <int Columns, class Around, class PositionOf>
FloatCopy<Columns> mended(const MappedSurface& map, typename FloatCopy<Columns>::Numbers rounded,
                          const Around& around, const PositionOf& positionOf) {
  constexpr int rounds = 5;
  const ClosedSurface& surface = map.surface();
  FloatCopy<Columns> copy{std::move(rounded), 0, false};
  Points positions(copy.numbers.rows(), 3);
  for (Eigen::Index v = 0; v < positions.rows(); ++v)
    positions.row(v) = positionOf(copy.numbers.row(v)).transpose();
  const auto improve = [&](int v) {
    double best = minSolidAngleAround(surface, positions, v, positions.row(v).transpose());
    bool moved = false;
    for (const auto& floats : around(copy.numbers.row(v))) {
      const Vector3 place = positionOf(floats);
      const double least = minSolidAngleAround(surface, positions, v, place);
      if (least <= best) continue;
      best = least;
      moved = true;
      copy.numbers.row(v) = floats;
    }
    if (moved) positions.row(v) = positionOf(copy.numbers.row(v)).transpose();
    copy.mendedVertices += moved;
  };
  for (int round = 0;; ++round) {
    copy.valid = certify(surface.faces(), positions).valid();
    if (copy.valid || round == rounds) return copy;
    for (int f = 0; f < surface.faceCount(); ++f)
      if (isTooSmall(surface, positions, f))
        for (int k = 0; k < 3; ++k) improve(surface.faces()(f, k));
  }
}

/// The floats nearest to points of a fine grid around the vertex, in units of a float's last place
/// below 1. Where a coordinate is small its floats lie closer, and several grid points may stand
/// for places that differ little.
std::vector<Eigen::RowVector3f> positionsAround(const Eigen::RowVector3f& position) {
  constexpr int reach = 2;
  constexpr double step = 1.0 / (1 << 24);
  std::vector<Eigen::RowVector3f> around;
  for (int i = -reach; i <= reach; ++i)
    for (int j = -reach; j <= reach; ++j)
      for (int k = -reach; k <= reach; ++k) {
        const Vector3 moved = position.transpose().cast<double>() + step * Vector3(i, j, k);
        around.emplace_back(moved.normalized().transpose().cast<float>());
      }
  return around;
}

float shifted(float x, int steps) {
  for (; steps > 0; --steps) x = std::nextafter(x, 2.0F);
  for (; steps < 0; ++steps) x = std::nextafter(x, -1.0F);
  return x;
}

std::vector<Eigen::RowVector2f> coordinatesAround(const Eigen::RowVector2f& coordinates) {
  constexpr int reach = 3;
  std::vector<Eigen::RowVector2f> around;
  for (int i = -reach; i <= reach; ++i)
    for (int j = -reach; j <= reach; ++j) {
      const float u = shifted(coordinates[0], i), v = shifted(coordinates[1], j);
      if (u >= 0 && u <= 1 && v >= 0 && v <= 1) around.emplace_back(u, v);
    }
  return around;
}

Vector3 positionOfTexture(const Eigen::RowVector2f& coordinates) {
  return spherePosition(coordinates.transpose().cast<double>());
}

}  // namespace

PositionCopy copyToFloat(const MappedSurface& map) {
  return mended<3>(
      map, map.positions().cast<float>(), positionsAround,
      [](const Eigen::RowVector3f& floats) { return Vector3(floats.transpose().cast<double>()); });
}

TextureCopy copyToTexture(const MappedSurface& map) {
  TextureCopy::Numbers coordinates(map.vertexCount(), 2);
  for (int v = 0; v < map.vertexCount(); ++v)
    coordinates.row(v) = textureCoordinate(map.position(v)).cast<float>().transpose();
  return mended<2>(map, std::move(coordinates), coordinatesAround, positionOfTexture);
}

Points positionsFromTexture(const TextureCopy::Numbers& coordinates) {
  Points positions(coordinates.rows(), 3);
  for (Eigen::Index v = 0; v < coordinates.rows(); ++v)
    positions.row(v) = positionOfTexture(coordinates.row(v)).transpose();
  return positions;
}

}  // namespace sphere_propagation
