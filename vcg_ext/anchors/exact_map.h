// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A map moved until given points of its surface lie at given places of the sphere, as
/// E. Praun, W. Sweldens, P. Schroeder, Consistent mesh parameterizations, 2001, and A. Asirvatham,
/// E. Praun, H. Hoppe, Consistent spherical parameterization, 2005, ask of their base vertices.
///
/// Here they need no base mesh: the map flows along v(x) = w(x) x x, w = sum_k K(x, p_k) w_k, a
/// field of rotations about the centre with a Gaussian K of chordal width h, p_k the places of the
/// points. The w_k are tangent at p_k and such that p_k sets out along the great circle to its
/// target; within 1e-3 radians of it, p_k as interpolated from corners that move with v. The
/// corners of a point's face go with it, each face as it is. The flow of a smooth field folds
/// nothing; its steps, of at most 0.15 h, are looked at one by one, and faces that flip are
/// untangled at once, the corners of the points' faces held. h is twice the longest way, within
/// 0.12 and 0.6.
///
/// Where the longest way w is beyond 0.15 radians, what the flow squeezes and stretches is spread
/// over the sphere, every 0.3 radians and in the end: with what is held in place, the energy of
/// area_energy.h is lowered, areas weighing 1 and shapes 3, towards the given map's areas and
/// towards shapes of faces between the given map's and, the more the farther (a share of 2 w, at
/// most 1), the surface's: so far a move leaves little of the given map to be kept. All of this is
/// done with a tenth of the vertices, at least 800, among them the corners of the points' faces
/// (coarse_map.h); the others come back in between, and the energy is lowered again whenever there
/// are 2.5 times as many, and with all. Where that finds no map, and of small meshes, all vertices
/// take part from the beginning.
///
/// Where a step cannot be untangled, what is there is spread first, and half the step taken, down
/// to a 20th, before it is mended, points and all. Where this finds no map, a second try mends at
/// once, and a third flows alone, faces of points moved as all others, and spreads in the end only.

#include <string>
#include <vector>

#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

/// How near each point comes to its target, radians.
constexpr double exactDistance = 1e-12;

struct ExactMap {
  MappedSurface map;
  int steps = 0;
  int untangledFaces = 0;  ///< that flipped in a step, all steps together
  double longestWay = 0;   ///< of a point on the sphere, radians
};

/// The place of a point on the sphere: interpolated in its face, then brought to length 1.
Vector3 placeOf(const MappedSurface& map, const SurfacePoint& point);

/// points: of the surface; targets: unit vectors, one for each; names: of the points, for errors.
/// Without points the map stays as it is. Throws AnchorError, which names the surface and the
/// points, where two of them lie in one place, where two would have to pass each other (they come
/// nearer on their ways than a fifth of what they are apart before and after), and where no valid
/// map was found.
ExactMap holdExactly(const MappedSurface& map, const std::vector<SurfacePoint>& points,
                     const std::vector<Vector3>& targets, const std::vector<std::string>& names);

}  // namespace sphere_propagation
