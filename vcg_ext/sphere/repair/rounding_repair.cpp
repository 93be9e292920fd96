// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/repair/rounding_repair.h"

#include <algorithm>
#include <limits>

#include "vcg_ext/sphere/certificate.h"
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

/// Index of the place that leaves the smallest face around v largest; -1 when that is where it is.
int bestPlace(const ClosedSurface& surface, const Points& positions, int v,
              const std::vector<Vector3>& places) {
  double best = minSolidAngleAround(surface, positions, v, positions.row(v).transpose());
  int found = -1;
  for (size_t i = 0; i < places.size(); ++i) {
    const double least = minSolidAngleAround(surface, positions, v, places[i]);
    if (least <= best) continue;
    best = least;
    found = static_cast<int>(i);
  }
  return found;
}

}  // namespace

RoundingRepair repairRounding(const ClosedSurface& surface, Points& positions,
                              const PlacesAround& placesAround, const Moved& moved) {
  constexpr int rounds = 5;
  RoundingRepair repair;
  for (int round = 0;; ++round) {
    repair.valid = certify(surface.faces(), positions).valid();
    if (repair.valid || round == rounds) return repair;
    for (int f = 0; f < surface.faceCount(); ++f) {
      const auto at = [&](int k) {
        return Vector3(positions.row(surface.faces()(f, k)).transpose());
      };
      if (solidAngle(at(0), at(1), at(2)) >= Certificate::minSolidAngle) continue;
      for (int k = 0; k < 3; ++k) {
        const int v = surface.faces()(f, k);
        const std::vector<Vector3> places = placesAround(v);
        const int place = bestPlace(surface, positions, v, places);
        if (place < 0) continue;
        positions.row(v) = places[static_cast<size_t>(place)].transpose();
        moved(v, place);
        ++repair.movedVertices;
      }
    }
  }
}

}  // namespace sphere_propagation
