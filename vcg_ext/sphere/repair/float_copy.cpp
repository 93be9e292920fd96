// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/repair/float_copy.h"

#include <vector>

#include "vcg_ext/sphere/repair/rounding_repair.h"

namespace sphere_propagation {

FloatCopy copyToFloat(const MappedSurface& map) {
  FloatCopy copy;
  copy.positions = map.positions().cast<float>();
  Points positions = copy.positions.cast<double>();
  // The floats nearest to points of a fine grid around the vertex, in units of a float's last place
  // below 1. Where a coordinate is small its floats lie closer, and several grid points may stand
  // for places that differ little.
  std::vector<Eigen::RowVector3f> around;
  const auto placesAround = [&](int v) {
    constexpr int reach = 2;
    constexpr double step = 1.0 / (1 << 24);
    around.clear();
    std::vector<Vector3> places;
    for (int i = -reach; i <= reach; ++i)
      for (int j = -reach; j <= reach; ++j)
        for (int k = -reach; k <= reach; ++k) {
          const Vector3 moved = positions.row(v).transpose() + step * Vector3(i, j, k);
          around.emplace_back(moved.normalized().transpose().cast<float>());
          places.emplace_back(around.back().transpose().cast<double>());
        }
    return places;
  };
  const auto moved = [&](int v, int place) {
    copy.positions.row(v) = around[static_cast<size_t>(place)];
  };
  const RoundingRepair repair = repairRounding(map.surface(), positions, placesAround, moved);
  copy.mendedVertices = repair.movedVertices;
  copy.valid = repair.valid;
  return copy;
}

}  // namespace sphere_propagation
