// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A root's map with anchors at places of the user's choice: the base domain of E. Praun,
/// W. Sweldens and P. Schroeder, Consistent mesh parameterizations, 2001, on the sphere. Surfaces
/// whose roots have the same anchors at the same places have maps in one frame.

#include <string>
#include <vector>

#include "vcg_ext/anchors/exact_map.h"
#include "vcg_ext/base/progress.h"
#include "vcg_ext/base/thread_pool.h"

namespace sphere_propagation {

struct PlacedRootMap {
  MappedSurface map;
  double turn = 0;        ///< of the whole map, radians
  double longestWay = 0;  ///< of a point after that, radians
};

/// First the rotation that brings the points nearest to their places (least squares), then the flow
/// of exact_map.h, which brings each to its place to exactDistance, and last the minimisation of
/// area_preserving_map.h with the corners of the points' faces held: areas are as near to the
/// surface's as the places allow.
///
/// points: of the surface; places: for each a unit vector; names: for what is thrown. areaWeight:
/// as in area_preserving_map.h. Throws AnchorError as holdExactly, and ParameterError.
PlacedRootMap placeAnchors(const MappedSurface& map, const std::vector<SurfacePoint>& points,
                           const std::vector<Vector3>& places,
                           const std::vector<std::string>& names, double areaWeight,
                           const Progress& progress = {}, ThreadPool* pool = nullptr);

}  // namespace sphere_propagation
