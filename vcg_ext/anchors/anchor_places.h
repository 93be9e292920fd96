// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Anchors as points of their surfaces.

#include <string>
#include <vector>

#include "vcg_ext/anchors/anchor_set.h"
#include "vcg_ext/mesh/surface_locator.h"

namespace sphere_propagation {

/// The anchors that a root has, on all surfaces.
struct AnchorPlaces {
  std::vector<std::string> names;  ///< of the root's anchors, in their order
  /// By surface, then by name: the closest point of the surface; face -1 where it lacks the anchor.
  /// Empty: there are no anchors.
  std::vector<std::vector<SurfacePoint>> points;

  bool empty() const { return points.empty(); }
  bool has(size_t surface, size_t anchor) const { return points[surface][anchor].face >= 0; }
  /// The numbers of the anchors that a surface has.
  std::vector<size_t> of(size_t surface) const;
  /// Lists of numbers among those that a surface has, as numbers among all names.
  std::vector<std::vector<size_t>> named(size_t surface,
                                         const std::vector<std::vector<int>>& lists) const;
};

/// What became of a surface's anchors: one number per name, NaN where it lacks that anchor or where
/// nothing is known.
struct AnchorFigures {
  /// From where its parent's motion brings the root's anchor, before the layer was fitted.
  std::vector<double> before;
  /// From the point of the surface that its map has at the place of the root's anchor.
  std::vector<double> after;
  std::vector<double> standardised;  ///< LayerAnchors::standardised, motion_anchors.h
  double widening = 1;               ///< of the prior's covariance (motion_anchors.h)
  std::vector<std::vector<size_t>> exchanged = {};  ///< LayerAnchors::exchanged, by name
};

/// The points of a surface that are closest to its anchors, in the order of names; face -1 where it
/// lacks one.
std::vector<SurfacePoint> closestPoints(const SurfaceLocator& surface, const AnchorSet& anchors,
                                        const std::vector<std::string>& names);

}  // namespace sphere_propagation
