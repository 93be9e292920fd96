// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Mends what rounding did to a map: for copies of it in fewer digits.

#include <functional>
#include <vector>

#include "vcg_ext/mesh/closed_surface.h"

namespace sphere_propagation {

/// The places that a vertex may be moved to, its own left out: those that the copy can express,
/// near where it is.
using PlacesAround = std::function<std::vector<Vector3>(int vertex)>;
/// Told that a vertex was moved to the place with this index among those last asked for.
using Moved = std::function<void(int vertex, int place)>;

struct RoundingRepair {
  int movedVertices = 0;  ///< moves that were made
  bool valid = false;     ///< whether the positions certify now
};

/// Makes rounded positions (#V by 3) a valid map again where that takes small moves: each vertex of
/// a face that is flipped or too small goes to the place that leaves the smallest face around it
/// largest, in a few rounds.
RoundingRepair repairRounding(const ClosedSurface& surface, Points& positions,
                              const PlacesAround& placesAround, const Moved& moved);

}  // namespace sphere_propagation
