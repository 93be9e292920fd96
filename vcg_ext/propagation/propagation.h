// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Propagation of a map from the root over all surfaces of a sequence.

#include <memory>
#include <optional>

#include "vcg_ext/anchors/anchor_set.h"
#include "vcg_ext/base/progress.h"
#include "vcg_ext/propagation/motion/motion_propagation.h"
#include "vcg_ext/propagation/published/published_propagation.h"
#include "vcg_ext/propagation/strategy.h"

namespace sphere_propagation {

enum class PropagationMethod {
  Robust,       ///< robust_strategy.h
  AsPublished,  ///< published_strategy.h
};

enum class AnchorUse {
  Off,
  Soft,   ///< they take part in the fit (motion_anchors.h), as pairs of R in the published steps
  Exact,  ///< as Soft, and then each map is moved until it holds them (exact_map.h)
};

struct AnchorParameters {
  AnchorUse use = AnchorUse::Soft;
  /// Standard deviation of a click per coordinate, in the unit of the vertices; 0: the surface's
  /// mean edge length.
  double deviation = 0;
  /// One set per surface, or none at all. Those that the root lacks are not looked at.
  std::vector<AnchorSet> layers = {};
  /// Whether surfaces that share three with the root are laid by them onto its (posesByAnchors),
  /// whatever shapes say, before the steps of either method.
  bool layPoses = false;
};

struct PropagationParameters {
  PropagationMethod method = PropagationMethod::Robust;
  PublishedParameters published = {};  ///< of method AsPublished
  /// In [0, 1]: how far each surface's map is moved towards area preservation in the end
  /// (area_restoration.h). What goes down the tree is the map before that, and the root keeps the
  /// map that it has.
  double areaRestoration = 0;
  /// An arc of surfaces that close a cycle, beside the tree: its map is compared with the one that
  /// the tree brings. Where it joins the ends of the tree's two branches (closingArc), method
  /// Robust averages both ways round (motion_cycle.h).
  std::optional<Arc> closing = {};
  int threads = 0;  ///< 0: as many as the machine runs at once; the maps are the same with any
  MotionParameters motion = {};  ///< of method Robust
  AnchorParameters anchors = {};
};

/// Throws ParameterError where a parameter is out of range, whatever the surfaces.
void requireValid(const PropagationParameters& parameters);

/// The surfaces that lie much farther off what was brought onto them than the others do, as another
/// shape does: by a factor of 3 and 6 standard deviations of the logarithm (both from the median of
/// at least three), residuals counted in radii, and by more than half an edge. One entry per
/// surface.
std::vector<char> residualsThatStandOut(const Sequence& sequence,
                                        const std::vector<PropagatedLayer>& layers);

/// sequence: the surfaces, in the order of the tree's numbers; root: the surface of the tree's
/// root, with its map; tree: one entry per surface, of any of the orders in propagation_order.h.
/// Throws ParameterError when the arguments do not fit together or a parameter is out of range, and
/// what the method throws, which names the surface; with exact anchors, AnchorError as holdExactly
/// does.
Propagation propagate(const Sequence& sequence, const MappedSurface& root,
                      const PropagationTree& tree, const PropagationParameters& parameters = {},
                      const Progress& progress = {});

/// The same by the threads of this pool; parameters.threads is not looked at.
Propagation propagate(const Sequence& sequence, const MappedSurface& root,
                      const PropagationTree& tree, ThreadPool& pool,
                      const PropagationParameters& parameters = {}, const Progress& progress = {});

}  // namespace sphere_propagation
