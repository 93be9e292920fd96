// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Propagation by following the root's motion through all surfaces, instead of handing its map from
/// surface to surface.
///
/// The root's surface is moved onto each surface by a low-rank motion model (motion_model.h) that
/// is fitted along the tree (motion_fit.h), and the surface's map is read off the moved root
/// (map_transfer.h). Nothing is resampled on the way, so nothing is lost but what the fits lose;
/// and what surfaces cannot show, how they slide along themselves, is decided by a prior that is
/// learnt from the sequence where it is long enough (motion_learning.h). Where that is so and the
/// tree is a chain, or makes a cycle with the closing arc, all surfaces are then fitted at once
/// (motion_smoothing.h).

#include <optional>
#include <vector>

#include "vcg_ext/anchors/anchor_places.h"
#include "vcg_ext/base/progress.h"
#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/propagation/motion/motion_prior.h"
#include "vcg_ext/propagation/transfer/map_transfer.h"
#include "vcg_ext/sequence/propagation_tree.h"
#include "vcg_ext/sequence/sequence.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

struct MotionParameters {
  /// The fewest arcs that a prior is learnt from, whatever the order; with fewer it is the fixed
  /// one (motion_prior.h).
  int minArcsToLearnFrom = 11;
  /// Whether all surfaces of a chain are fitted at once in the end (motion_smoothing.h), where the
  /// prior was learnt. Off: arc by arc alone, for comparison.
  bool smooths = true;
  /// Whether the uncertainty of each surface's landmarks is asked for (motion_uncertainty.h).
  bool uncertainty = false;
};

struct FollowedLayer {
  TransferredMap transferred;
  double seconds = 0;                ///< wall clock: its reading, and its share of the fits
  Eigen::VectorXd uncertainty = {};  ///< #V, in the unit of length, where asked for
};

/// Two maps of the surface where a closing arc ends.
struct ClosingMaps {
  MappedSurface carried;  ///< that the arc carries there
  MappedSurface brought;  ///< that the tree brings there, neither averaged nor smoothed
};

struct FollowedMotion {
  /// One entry per surface; empty at the root, and at surfaces that the fit lost: its residual is
  /// too large (maxEdgesApart), or its map cannot be repaired. In a cycle, only where both ways
  /// round are lost.
  std::vector<std::optional<FollowedLayer>> layers;
  /// Of each surface, where there are anchors: all but `after`.
  std::vector<AnchorFigures> anchors;
  std::optional<MotionVariances> learnt;  ///< where a prior was learnt
  std::optional<ClosingMaps> closing;     ///< empty where one of them is lost
  int averaged = 0;  ///< surfaces where both ways round a cycle agree, and are averaged
  int smoothed =
      0;  ///< surfaces whose motion was fitted to all of a chain at once; not in `averaged`
  /// Where some were: what the root's surface lacks outwards at each of its vertices (e of
  /// motion_smoothing.h).
  Eigen::VectorXd rootError = {};
};

/// sequence: the surfaces, in one frame; root: the map of the tree's root among them; tree: one
/// entry per surface; pool: who does the work, with the same result whatever the number of threads;
/// closing: an arc beside the tree. Where the two make a cycle of all surfaces, each surface's
/// motion is, before that, the average of both ways round (motion_cycle.h), and what one way loses
/// comes the other way. anchors: on the surfaces; deviations: sd of those of each surface
/// (motion_anchors.h). With anchors, nothing is smoothed.
FollowedMotion followMotion(const Sequence& sequence, const MappedSurface& root,
                            const PropagationTree& tree, ThreadPool& pool,
                            const Progress& progress = {}, const std::optional<Arc>& closing = {},
                            const MotionParameters& parameters = {},
                            const AnchorPlaces& anchors = {},
                            const std::vector<double>& deviations = {});

}  // namespace sphere_propagation
