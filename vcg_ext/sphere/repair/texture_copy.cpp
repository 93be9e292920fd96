// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/repair/texture_copy.h"

#include <cmath>
#include <vector>

#include "vcg_ext/sphere/repair/rounding_repair.h"
#include "vcg_ext/sphere/sphere_coordinates.h"

namespace sphere_propagation {
namespace {

float shifted(float x, int steps) {
  for (; steps > 0; --steps) x = std::nextafter(x, 2.0F);
  for (; steps < 0; ++steps) x = std::nextafter(x, -1.0F);
  return x;
}

}  // namespace

Points positionsFromTexture(
    const Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor>& coordinates) {
  Points positions(coordinates.rows(), 3);
  for (Eigen::Index v = 0; v < coordinates.rows(); ++v)
    positions.row(v) = spherePosition(coordinates.row(v).transpose().cast<double>()).transpose();
  return positions;
}

TextureCopy copyToTexture(const MappedSurface& map) {
  TextureCopy copy;
  copy.coordinates.resize(map.vertexCount(), 2);
  for (int v = 0; v < map.vertexCount(); ++v)
    copy.coordinates.row(v) = textureCoordinate(map.position(v)).cast<float>().transpose();
  Points positions = positionsFromTexture(copy.coordinates);
  std::vector<Eigen::RowVector2f> around;
  const auto placesAround = [&](int v) {
    constexpr int reach = 3;
    around.clear();
    std::vector<Vector3> places;
    for (int i = -reach; i <= reach; ++i)
      for (int j = -reach; j <= reach; ++j) {
        const float a = shifted(copy.coordinates(v, 0), i), b = shifted(copy.coordinates(v, 1), j);
        if (a < 0 || a > 1 || b < 0 || b > 1) continue;
        around.emplace_back(a, b);
        places.push_back(spherePosition({a, b}));
      }
    return places;
  };
  const auto moved = [&](int v, int place) {
    copy.coordinates.row(v) = around[static_cast<size_t>(place)];
  };
  const RoundingRepair repair = repairRounding(map.surface(), positions, placesAround, moved);
  copy.mendedVertices = repair.movedVertices;
  copy.valid = repair.valid;
  return copy;
}

}  // namespace sphere_propagation
