// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Propagation of a map by laying the reference on the target and reading the map off it.
///
/// The published steps (published_propagation.h) know positions only where vertices are each
/// other's nearest, and smooth all of the sphere; so every arc pulls the map towards one that the
/// mesh prefers. Here each vertex is read off the closest surface point, and only what is flipped
/// is smoothed.

#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/propagation/transfer/map_transfer.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

/// One arc of the propagation tree: brings the reference onto the target, then transferMap
/// (map_transfer.h).
///
/// Brought onto it: centroids together, the paper's rigid alignment (rigid_alignment.h), then an
/// affine one by closest surface points with agreeing normals, all of the surface weighing the
/// same, damped. The paper's scaling by principal axes, either way round, is no help on beating
/// ventricles: their axes turn and change places. An affine fit sees the surfaces themselves.
///
/// reference: the surface that has a map; target: the surface that gets one. The residual is the
/// distance of the target's vertices from the reference as moved, at the points read off. Throws
/// MapError, which names the target, when the result cannot be repaired.
TransferredMap propagateAligned(const MappedSurface& reference, const ClosedSurface& target);

}  // namespace sphere_propagation
