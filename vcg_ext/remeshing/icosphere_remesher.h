// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Remeshing of many surfaces by one icosphere: what is the same for all is made once.

#include <vector>

#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/remeshing/remeshing.h"

namespace sphere_propagation {

/// Several threads may share one.
class IcosphereRemesher {
 public:
  /// Throws ParameterError as icosphere does.
  explicit IcosphereRemesher(int frequency);

  const Icosphere& sphere() const { return sphere_; }

  /// remesh by the vertices of the icosphere.
  Remeshed remesh(const MappedSurface& surface) const;

  /// surfaceDistance between a surface and the landmarks that remesh made of it. The map tells
  /// where to look: the closest point lies near the one under the same direction, and the
  /// icosphere's order of faces is one of the surface's, too, so that no tree has to be sorted.
  SurfaceDistance distance(const Remeshed& remeshed, const MappedSurface& mapped) const;

 private:
  Icosphere sphere_;
  MappedSurface connected_;  // the icosphere, to walk over
  std::vector<int> order_;   // of its faces, in which neighbours are near
  std::vector<int> rank_;    // of each face in that order
};

}  // namespace sphere_propagation
