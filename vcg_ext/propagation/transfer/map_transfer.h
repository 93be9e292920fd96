// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What an arc of propagation ends in, however it was made; and the way it is made most often: a
/// map is read off a reference that was moved onto another surface.

#include <vector>

#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/propagation/transfer/residual.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

/// Normals agree where their dot product is at least this, about 73 degrees: neighbouring phases
/// turn a normal by less, and the other side of a wall looks the other way.
constexpr double minNormalAgreement = 0.3;

/// A map that came to a surface from another one.
struct TransferredMap {
  MappedSurface map;      ///< of the target, valid
  int repairedFaces = 0;  ///< faces that were flipped before the repair
  Residual residual;      ///< of the distances
  std::vector<double>
      distances;  ///< #V of the target: from each vertex to the point that it was read off at
};

/// Gives each vertex of the target the sphere position at the closest point of the moved reference,
/// interpolated on the face and normalised; then untangles what is flipped (untangling.h), and
/// nothing else.
///
/// Only faces that look the same way count as close: those whose normal, as moved, has a dot
/// product of at least 0.3 with the vertex' normal, so that the two sides of a thin wall keep
/// apart. A vertex at a tip, whose normal agrees with none of its own faces as well as that, asks
/// no more of others than nine tenths of what the best of its own reaches; one whose normals
/// cancel, or with which no face agrees, takes the closest of all faces. So a surface that is read
/// off itself gets the map that it has.
///
/// As positions are interpolated, a target with more vertices than the reference needs no repair
/// for that.
///
/// reference: the surface that has a map; movedVertices: #V of the reference by 3, finite, where
/// its vertices are when it lies on the target; target: the surface that gets a map. Throws
/// ParameterError, which names the reference, when the vertices are not its own, MapError, which
/// names the target, when the repair fails.
TransferredMap transferMap(const MappedSurface& reference, const Points& movedVertices,
                           const ClosedSurface& target);

/// The same, for a reference that is read off many times. order: of a locator of its faces,
/// wherever its vertices are.
TransferredMap transferMap(const MappedSurface& reference, const Points& movedVertices,
                           const ClosedSurface& target, const std::vector<int>& order);

}  // namespace sphere_propagation
