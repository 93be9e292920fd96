// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Surfaces of another size than the rest of the sequence: one in centimetres among millimetres, or
/// another shape.

#include <vector>

#include "vcg_ext/sequence/propagation_tree.h"
#include "vcg_ext/sequence/sequence.h"

namespace sphere_propagation {

struct SurfaceSize {
  /// Of its radius (of the sphere of its area) to what the other surfaces suggest: the geometric
  /// mean of those beside it in the tree, where they are as they should be, else the median of all
  /// that are.
  double relative = 1;
  bool standsOut = false;  ///< whether that is no matter of growing or beating
  /// Where it stands out, the ratio of two units that `relative`, or its inverse, is close to (10,
  /// 25.4, 100 or 1000, within a factor of 1.5); 0: of none.
  double units = 0;

  /// What its vertices are multiplied by to be of the others' size: 1 where it does not stand out.
  double toOthers() const;
};

/// Two signs that a surface stands out, each either way, in logarithms of radii:
/// - apart: sorted by size, surfaces with a gap of a factor of 1.75 between them are of different
///   kinds, and the kind of most surfaces is the right one (of equals the root's), or, within it,
///   the surface is farther from the median than a factor of 2.2 and 6 standard deviations (from
///   the median absolute deviation);
/// - beside: it is larger than all that are beside it in the tree, or smaller, by a factor of 1.5
///   (1.75 where only one is beside it) and by 2.5 (3.5) times what is usual along the other arcs;
///   or, where several are beside it and there are five other arcs, by 1.25 and 4 times the usual.
/// Over a heart's cycle neighbours differ by up to 1.2, by 1.4 with three phases, and all phases by
/// up to 1.4; skulls of twelve species by up to 1.7. Of two surfaces it is the one that is not the
/// root. tree: one entry per surface.
std::vector<SurfaceSize> findSurfaceSizes(const Sequence& sequence, const PropagationTree& tree);

/// The sequence with the surfaces that stand out in the root's unit and of the others' size: about
/// the origin, as another unit would have it, or about the surface's centre, whichever leaves it
/// nearer to its parent. Where it is the root that stands out, all others are scaled.
Sequence inRootsSize(const Sequence& sequence, const std::vector<SurfaceSize>& sizes,
                     const PropagationTree& tree);

}  // namespace sphere_propagation
