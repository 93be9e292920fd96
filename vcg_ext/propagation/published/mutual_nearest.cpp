// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/published/mutual_nearest.h"

namespace sphere_propagation {

std::vector<VertexPair> mutualNearest(const VertexLocator& target, const VertexLocator& reference) {
  const std::vector<int> nearest = reference.nearest(target.points());
  std::vector<int> back(static_cast<size_t>(reference.points().rows()),
                        -1);  // asked only for those that are a nearest
  std::vector<VertexPair> pairs;
  for (int v = 0; v < static_cast<int>(nearest.size()); ++v) {
    const int w = nearest[v];
    if (back[w] < 0) back[w] = target.nearest(Vector3(reference.points().row(w).transpose()), v);
    if (back[w] == v) pairs.push_back({v, w});
  }
  return pairs;
}

}  // namespace sphere_propagation
