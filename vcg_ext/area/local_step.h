// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The local step of the area-preserving map: one vertex moves, its neighbours stay.

#include <vector>

#include "vcg_ext/area/area_energy.h"

namespace sphere_propagation {

/// The faces around a vertex; face i has the corners (vertex, rim[i], rim[i + 1]).
struct VertexStar {
  std::vector<Vector3> rim;         ///< unit vectors, counter-clockwise
  std::vector<FaceTarget> targets;  ///< stiffness[0] is the vertex's corner
};

/// Newton's method on the tangent plane, at most `iterations` steps of at most 0.5, each shortened
/// until the energy of the star falls and every face stays admissible (admissible.h). x: the
/// vertex, changed in place; from a place that is not admissible it does not move. Returns how far
/// it moved.
double relaxVertex(const VertexStar& star, const AreaEnergyWeights& weights, int iterations,
                   Vector3& x);

}  // namespace sphere_propagation
