// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Local repair of positions on the sphere that are almost a map: only the faces that are flipped,
/// and what lies around them, are touched.

#include <limits>
#include <vector>

#include "vcg_ext/base/progress.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

struct Untangled {
  MappedSurface map;
  int repairedFaces = 0;  ///< faces that were flipped before the repair
  int movedVertices = 0;  ///< vertices that lie elsewhere after it
};

/// Frees the vertices of the flipped faces and a ring of vertices around them, and puts each free
/// vertex at the mean of its neighbours weighted by 1 / edge length, all others fixed (W. T. Tutte,
/// How to draw a graph, 1963; the weights are those of the paper's smoothing), then back on the
/// sphere. Where faces are still flipped the ring grows: 1, 2, 3, and then half as many rings again
/// each time, so that long limbs take few rounds.
///
/// positions: #V by 3, any length but zero (they are normalised first; a zero or non-finite one
/// counts as free). maxRings: how far the ring may grow. progress: the largest share of the
/// vertices that was free. held: 1 for each vertex that stays where it is; empty: none. Throws
/// MapError when that does not end in a valid map: the positions are
/// too far from one.
Untangled untangle(const ClosedSurface& surface, Points positions,
                   int maxRings = std::numeric_limits<int>::max(), const Progress& progress = {},
                   const std::vector<char>& held = {});

/// untangle with up to 5 rings; where the folds are no local matter, the map near the positions
/// that is made from coarse to fine (nearby_map.h), which always is one. Throws MapError when there
/// is no room for a vertex.
Untangled mend(const ClosedSurface& surface, Points positions, const Progress& progress = {});

}  // namespace sphere_propagation
