// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Point location on the sphere for directions that come in a row, each near the one before.

#include <functional>
#include <optional>
#include <vector>

#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/sphere/mapped_surface.h"
#include "vcg_ext/sphere/sphere_locator.h"

namespace sphere_propagation {

/// Walks over the faces of a map towards a direction, from the face that was found last: O.
/// Devillers, S. Pion and M. Teillaud, Walking in a triangulation, 2002 (the visibility walk,
/// across the edge that the direction lies farthest beyond). A few faces for a neighbour; nothing
/// is built for it. Where a walk does not end, or ends so near an edge that rounding decides, a
/// SphereLocator, built then, answers.
///
/// Keeps references to what it is given, and where it is: one walk per thread.
class SphereWalk {
 public:
  explicit SphereWalk(MappedSurface surface);

  /// The same answer as SphereLocator::locate, and the same error.
  SurfacePoint locate(const Vector3& direction);

 private:
  MappedSurface surface_;
  int at_ = 0;
  std::optional<SphereLocator> locator_;
};

/// The face of a map that a walk towards a direction ends in: the one under the direction, or where
/// rounding decides, one beside it; after 16 + 4 sqrt(#F) faces wherever it is then. direction: a
/// unit vector; start: the face that the walk begins in.
int walkOverSphere(const MappedSurface& surface, const Vector3& direction, int start);

/// For each vertex of a map the face of another map under its position, as walk(position, start)
/// finds it. start: the face that was found for a neighbour, or for the vertex before.
std::vector<int> facesUnder(const MappedSurface& map,
                            const std::function<int(const Vector3&, int)>& walk);

}  // namespace sphere_propagation
