// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Propagation of a map by laying the reference on the target and reading the map off it.
///
/// The published steps (published_propagation.h) know positions only where vertices are each
/// other's nearest, and smooth all of the sphere; so every arc pulls the map towards one that the
/// mesh prefers. Here each vertex is read off the closest surface point, and only what is flipped
/// is smoothed.

#include <vector>

#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/sphere/sphere_map.h"

namespace sphere_propagation {

struct RobustPropagation {
  SphereMap map;          ///< of the target, valid
  int repairedFaces = 0;  ///< faces that were flipped as read off, before the repair
  double residualMean =
      0;  ///< distance of the target's vertices from the reference as moved, at the points read off
  double residualP95 = 0;  ///< the same, 95th percentile; both in the unit of the vertices
  std::vector<double> distances = {};  ///< #V of the target: what the residual is made of
};

/// One arc of the propagation tree: brings the reference onto the target, then transferMap
/// (map_transfer.h).
///
/// Brought onto it: centroids together, the paper's rigid alignment (rigid_alignment.h), then an
/// affine one by closest surface points with agreeing normals, all of the surface weighing the
/// same, damped. The paper's scaling by principal axes, either way round, is no help on beating
/// ventricles: their axes turn and change places. An affine fit sees the surfaces themselves.
///
/// reference: the surface that has a map, referenceMap: that map; target: the surface that gets
/// one. Throws ParameterError when referenceMap is no map of the reference, MapError, which names
/// the target, when the result cannot be repaired.
RobustPropagation propagateRobustly(const ClosedSurface& reference, const SphereMap& referenceMap,
                                    const ClosedSurface& target);

}  // namespace sphere_propagation
