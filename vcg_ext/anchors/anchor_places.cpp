// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/anchors/anchor_places.h"

namespace sphere_propagation {

std::vector<size_t> AnchorPlaces::of(size_t surface) const {
  std::vector<size_t> there;
  for (size_t k = 0; !empty() && k < names.size(); ++k)
    if (has(surface, k)) there.push_back(k);
  return there;
}

std::vector<std::vector<size_t>> AnchorPlaces::named(
    size_t surface, const std::vector<std::vector<int>>& lists) const {
  const std::vector<size_t> there = of(surface);
  std::vector<std::vector<size_t>> named;
  for (const std::vector<int>& list : lists) {
    named.emplace_back();
    for (const int k : list) named.back().push_back(there[static_cast<size_t>(k)]);
  }
  return named;
}

std::vector<SurfacePoint> closestPoints(const SurfaceLocator& surface, const AnchorSet& anchors,
                                        const std::vector<std::string>& names) {
  std::vector<SurfacePoint> points(names.size());
  for (size_t k = 0; k < names.size(); ++k)
    if (const auto anchor = anchors.find(names[k]); anchor != anchors.end())
      points[k] = surface.closest(anchor->second);
  return points;
}

}  // namespace sphere_propagation
