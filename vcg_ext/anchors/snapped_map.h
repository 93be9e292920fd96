// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A root's map moved until its anchors lie at vertices of the icosphere, so that remeshing makes
/// them landmarks: number landmarks[k] is anchor k on every surface whose map holds it.

#include <string>
#include <vector>

#include "vcg_ext/anchors/exact_map.h"

namespace sphere_propagation {

/// Of the icosphere that anchors are brought to. Its vertices are vertices of those of its
/// multiples as well, with other numbers (icosphere.h).
constexpr int snapFrequency = 10;

struct SnappedMap {
  MappedSurface map;
  std::vector<int> landmarks;  ///< of each point, its vertex of icosphere(snapFrequency)
};

/// Each point goes to the vertex that is nearest to its place on the sphere, no two to one: the
/// nearest pair of all goes first. points, names and what is thrown: as of holdExactly. There must
/// not be more points than vertices.
SnappedMap snapToLandmarks(const MappedSurface& map, const std::vector<SurfacePoint>& points,
                           const std::vector<std::string>& names);

}  // namespace sphere_propagation
