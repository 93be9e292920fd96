// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The union of two connectivities on the sphere: one mesh that has the vertices of both surfaces,
/// and all of their edges. M. Alexa, Merging polyhedral shapes with scattered features, 2000,
/// section 5.
///
/// Which edges cross, and in which order, is decided exactly (side_of_arc.h), and the faces follow
/// from that alone: where an edge of one meets an edge of the other there is a vertex, and the
/// edges round a vertex are in the order that they have on their own mesh. So the result is closed
/// and of genus 0 whatever rounding makes of coordinates. The cells between the edges, which are
/// convex and have up to six corners, are cut into triangles.
///
/// Places where nothing is general (a vertex of one map at a vertex or on an edge of the other) are
/// left by turning the second map by a few times 1e-6 radians; what corresponds to what changes by
/// as little.

#include <optional>

#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

struct SphereOverlay {
  /// What both have in common: the faces on the first surface, whose shape it is exactly, and its
  /// map. The vertices are those of the first, those of the second, and the crossings, in this
  /// order.
  MappedSurface first;
  /// The same faces on the second surface, whose shape it is exactly.
  ClosedSurface second;
  int crossings = 0;
  double turn = 0;  ///< by which the second map was turned, radians
};

/// Two maps of the same faces that agree within 1e-9 have one connectivity already, which is
/// returned. Nothing where no turn leads to a valid map, as faces are too small.
std::optional<SphereOverlay> overlayOnSphere(const MappedSurface& first,
                                             const MappedSurface& second);

}  // namespace sphere_propagation
