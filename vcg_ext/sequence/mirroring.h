// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Layers that are mirror images of the others, a left bone among right ones, and what makes them
/// alike: what groomers of shape models call to reflect (J. Cates, S. Elhabian and R. Whitaker,
/// ShapeWorks: particle-based shape correspondence and visualization software, 2017).

#include <optional>
#include <vector>

#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/sequence/propagation_order.h"
#include "vcg_ext/sequence/propagation_tree.h"
#include "vcg_ext/sequence/sequence.h"

namespace sphere_propagation {

/// The surface reflected across the plane x = plane: (x, y, z) goes to (2 plane - x, y, z). Corners
/// 1 and 2 of each face are exchanged, so that it looks outward as before; numbers of vertices and
/// faces stay.
ClosedSurface mirrorImage(const ClosedSurface& surface, double plane = 0);

/// For each layer that is a mirror image of the root's kind the plane x = ... that it is to be
/// reflected across, which passes through its centroid (of its area).
///
/// A layer is one where its mirror image fits its parent better than itself by more than the
/// factor 1.15, each in its best pose (distances as in shape_alignment.h). The parent is reflected
/// first where it is one: so a left bone behind a left bone is found as well, and a right one
/// behind it is not. The root is none. What is its own mirror image, as skulls are nearly, stays.
/// Where shapes differ much more than left and right do, it cannot be told, and they stay too.
std::vector<std::optional<double>> findMirrorPlanes(const Sequence& sequence,
                                                    const PropagationTree& tree, ThreadPool& pool);

struct ReflectedSequence {
  Sequence sequence;                          ///< with those layers reflected
  std::vector<std::optional<double>> planes;  ///< across which each was; nothing: it was not
  PropagationTree tree;                       ///< of the order, for the sequence as it is now
};

/// Reflects the layers that findMirrorPlanes finds. Where the order goes by shape, which shapes are
/// alike may be another matter then: tree and search are made again until nothing is found. No
/// layer is reflected twice.
ReflectedSequence reflectMirrorImages(const Sequence& sequence, const PropagationOrder& order,
                                      int root, ThreadPool& pool);

}  // namespace sphere_propagation
