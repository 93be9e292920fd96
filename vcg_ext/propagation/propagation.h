// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Propagation of a map from the root over all layers, one arc of the tree after the other.

#include <optional>
#include <vector>

#include "vcg_ext/base/progress.h"
#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/propagation/motion/motion_fit.h"
#include "vcg_ext/propagation/published/published_propagation.h"
#include "vcg_ext/propagation/transfer/map_difference.h"
#include "vcg_ext/sequence/layer_poses.h"
#include "vcg_ext/sequence/propagation_tree.h"
#include "vcg_ext/sphere/sphere_map.h"

namespace sphere_propagation {

enum class PropagationMethod {
  Robust,       ///< motion_propagation.h; for layers that it loses robust_propagation.h, then the
                ///< published steps
  AsPublished,  ///< published_propagation.h
};

struct PropagationParameters {
  PropagationMethod method = PropagationMethod::Robust;
  PublishedParameters published;  ///< of method AsPublished
  /// In [0, 1]: how far each layer's map is moved towards area preservation in the end
  /// (area_restoration.h). What goes down the tree is the map before that, and the root keeps the
  /// map that it has.
  double areaRestoration = 0;
  /// An arc of layers that close a cycle, beside the tree: its map is compared with the one that
  /// the tree brings. Where it joins the ends of the tree's two branches (closingArc), method
  /// Robust averages both ways round (motion_cycle.h).
  std::optional<Arc> closing = {};
  int threads =
      0;  ///< 0: as many as the machine runs at once; the maps are the same with any number
};

/// Layers that differ more in size than this are in different units, and method Robust refuses
/// them.
constexpr double maxRelativeSize = 100;

/// How a layer got its map.
enum class Route {
  Method,     ///< by the method asked for
  Alignment,  ///< Robust, but the motion fit lost the layer: from its parent, aligned
              ///< (robust_propagation.h)
  Published,  ///< Robust, but that could not be repaired either: from its parent, as published
};

struct PropagatedLayer {
  SphereMap map;
  int parent = -1;          ///< the layer that the map comes from; -1 for the root
  int repairedFaces = 0;    ///< faces that were flipped before the repair
  double residualMean = 0;  ///< distance of the layer's vertices from its parent as brought onto it
  double residualP95 = 0;   ///< the same, 95th percentile; both in the unit of the vertices
  double seconds = 0;       ///< spent on this layer, wall clock
  Route route = Route::Method;
  LayerPose pose;           ///< in which method Robust brought it onto its parent
  double relativeSize = 1;  ///< of its radius (of the sphere of its area) to its parent's
  std::vector<double> distances = {};  ///< #V: what the residual is made of; zeros at the root
};

struct Propagation {
  std::vector<PropagatedLayer>
      layers;  ///< one entry per layer, in layer order; the root has rootMap as it is, and zeros
  /// Where the closing arc ends: between the map that it carries there and the one that the tree
  /// does.
  std::optional<MapDifference> closing;
  int averaged = 0;  ///< by method Robust in a closed cycle: layers whose motion is the average of
                     ///< both ways round
  std::optional<MotionVariances>
      learnt;  ///< by method Robust, where there was enough to learn from (motion_fit.h)
};

/// surfaces: the layers, in the order of the tree's numbers; rootMap: the map of
/// surfaces[tree.root()]; tree: one entry per layer, of any of the orders in propagation_tree.h or
/// similarity_tree.h. Progress goes by vertices. Throws ParameterError when the arguments do not
/// fit together or a parameter is out of range, and what the method throws, which names the layer.
Propagation propagate(const std::vector<ClosedSurface>& surfaces, const SphereMap& rootMap,
                      const PropagationTree& tree, const PropagationParameters& parameters = {},
                      const Progress& progress = {});

}  // namespace sphere_propagation
