// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// How maps get from the root to all other surfaces: what the methods of propagation have in
/// common.

#include <functional>
#include <optional>
#include <vector>

#include "vcg_ext/anchors/anchor_places.h"
#include "vcg_ext/base/progress.h"
#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/propagation/motion/motion_prior.h"
#include "vcg_ext/propagation/transfer/map_difference.h"
#include "vcg_ext/propagation/transfer/map_transfer.h"
#include "vcg_ext/sequence/propagation_tree.h"
#include "vcg_ext/sequence/sequence.h"
#include "vcg_ext/sequence/surface_poses.h"
#include "vcg_ext/sequence/surface_sizes.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

/// How a surface got its map.
enum class Route {
  Method,     ///< by the method asked for
  Alignment,  ///< Robust, but the motion fit lost the surface: from its parent, aligned
              ///< (aligned_propagation.h)
  Published,  ///< Robust, but that could not be repaired either: from its parent, as published
};

struct PropagatedLayer {
  TransferredMap transferred;  ///< the surface with its map, and what that took; zeros at the root
  int parent = -1;             ///< the surface that the map comes from; -1 for the root
  Route route = Route::Method;
  double seconds = 0;     ///< spent on this surface, wall clock
  SurfacePose pose = {};  ///< in which method Robust brought it onto its parent
  SurfaceSize size = {};  ///< beside the others
  /// Whether it lies much farther off than the others do (residualsThatStandOut).
  bool residualStandsOut = false;
  AnchorFigures anchors = {};  ///< empty where there are no anchors
  /// #V, where asked for (MotionParameters::uncertainty): how well tissue is known along the
  /// surface at each vertex, as the standard deviation of a coordinate (motion_uncertainty.h), in
  /// the unit of the vertices. Zero at the root; empty where the motion's fit did not make the map.
  Eigen::VectorXd uncertainty = {};

  const MappedSurface& map() const { return transferred.map; }
};

struct Propagation {
  std::vector<PropagatedLayer> layers;  ///< one entry per surface, in their order
  /// Where the closing arc ends: between the map that it carries there and the one that the tree
  /// does.
  std::optional<MapDifference> closing = {};
  int averaged = 0;  ///< by method Robust in a closed cycle: surfaces whose motion is the average
                     ///< of both ways round
  int smoothed = 0;  ///< by method Robust: surfaces whose motion was fitted to all of a chain or
                     ///< cycle at once (motion_smoothing.h); not in `averaged`
  /// By method Robust, where there was enough to learn from (motion_learning.h).
  std::optional<MotionVariances> learnt = {};
  /// By method Robust, where surfaces were fitted at once: what the root's surface lacks outwards
  /// at each of its vertices, as all surfaces together say; else empty.
  Eigen::VectorXd rootError = {};
};

struct PropagationTask {
  const Sequence& sequence;
  const MappedSurface& root;  ///< the surface of the tree's root, with its map
  const PropagationTree& tree;
  const std::optional<Arc>& closing;  ///< an arc beside the tree
  const std::vector<SurfaceSize>& sizes;
  ThreadPool& pool;
  const AnchorPlaces& anchors;                  ///< on the surfaces; empty: none
  const std::vector<double>& anchorDeviations;  ///< of each surface, in the unit of its vertices
  bool anchorsLayPoses = false;                 ///< AnchorParameters::layPoses
};

/// posesByAnchors of the sequence, as large as the strategy has it; none where anchors are not to
/// lay poses.
std::vector<SurfacePose> layByAnchors(const PropagationTask& task, const Sequence& sequence);

class PropagationStrategy {
 public:
  virtual ~PropagationStrategy() = default;
  /// Throws MapError or PropagationError, which name the surface that gets no map.
  virtual Propagation propagate(const PropagationTask& task, const Progress& progress) const = 0;
};

/// Makes the surfaces one after the other, parents before their children; the root's is as it is.
/// make: the surface i, given its parent's. Progress goes by vertices.
std::vector<PropagatedLayer> overArcs(
    const PropagationTask& task, const Progress& progress,
    const std::function<PropagatedLayer(int i, const PropagatedLayer& parent)>& make);

/// How the map that the closing arc of a task carries to its end differs from the one that is
/// there; empty where there is no such arc. carry: the map of surface `to`, given that of the
/// surface where the arc begins.
std::optional<MapDifference> overClosingArc(
    const PropagationTask& task, const std::vector<PropagatedLayer>& layers,
    const std::function<MappedSurface(const MappedSurface& from, int to)>& carry);

}  // namespace sphere_propagation
