// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/hierarchy/spatial_order.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace sphere_propagation {
namespace {

/// The lowest 21 bits of x, two zeros after each.
std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

}  // namespace

std::vector<int> spatialOrder(const Points& points) {
  const Vector3 low = points.colwise().minCoeff();
  const double extent = (points.colwise().maxCoeff().transpose() - low).maxCoeff();
  const double cells = extent > 0 ? 2097151 / extent : 0;
  std::vector<std::pair<std::uint64_t, int>> keys(static_cast<size_t>(points.rows()));
  for (int v = 0; v < static_cast<int>(keys.size()); ++v) {
    std::uint64_t key = 0;
    for (int k = 0; k < 3; ++k)
      key |= spread(static_cast<std::uint64_t>((points(v, k) - low[k]) * cells)) << k;
    keys[v] = {key, v};
  }
  std::sort(keys.begin(), keys.end());
  std::vector<int> order(keys.size());
  for (size_t i = 0; i < keys.size(); ++i) order[i] = keys[i].second;
  return order;
}

}  // namespace sphere_propagation
