// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/groupwise/opened_maps.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "vcg_ext/area/area_restoration.h"

namespace sphere_propagation {
namespace {

constexpr double usualBound = 3;
constexpr double none = 0.005, few = 0.01, pocketsOnly = 0.05, lost = 0.15;  // of the surface

/// usual: at least usualBound; squeezed: above none.
double boundFor(double squeezed, double usual) {
  if (squeezed < few) return usual * (few - none) / (squeezed - none);
  const double how = std::clamp((squeezed - pocketsOnly) / (lost - pocketsOnly), 0.0, 1.0);
  return usual * std::pow(usualBound, -how);
}

}  // namespace

std::vector<OpenedMap> openedMaps(const std::vector<MappedSurface>& maps, ThreadPool& pool) {
  const auto count = static_cast<int>(maps.size());
  const std::vector<double> needed = pool.makeEach(
      count, [&](int k) { return boundOfSqueezing(maps[static_cast<size_t>(k)], few); });
  const double usual = std::max(usualBound, *std::min_element(needed.begin(), needed.end()));
  return pool.makeEach(count, [&](int k) -> OpenedMap {
    const MappedSurface& map = maps[static_cast<size_t>(k)];
    const double squeezed = squeezedShare(map, usual);
    if (!(squeezed > none)) return {map, map, 0};
    MappedSurface opened = boundAreas(map, boundFor(squeezed, usual));
    MappedSurface pockets = squeezed > pocketsOnly ? boundAreas(map, usual) : opened;
    return {std::move(opened), std::move(pockets), squeezed};
  });
}

}  // namespace sphere_propagation
