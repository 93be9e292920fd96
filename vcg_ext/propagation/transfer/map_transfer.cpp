// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/transfer/map_transfer.h"

#include <algorithm>
#include <string>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/sphere/repair/untangling.h"

namespace sphere_propagation {
namespace {

constexpr double shareOfOwn = 0.9;

/// The least dot product of a face's normal with the normal of each vertex for the two to agree;
/// none (2) where the vertex has no normal.
std::vector<double> minCosines(const ClosedSurface& surface, const Points& vertexNormals) {
  const Points normals = faceNormals(surface.vertices(), surface.faces());
  std::vector<double> least(static_cast<size_t>(surface.vertexCount()));
  for (int v = 0; v < surface.vertexCount(); ++v) {
    double best = 0;
    for (int h : surface.outgoing(v))
      best = std::max(best, normals.row(h / 3).dot(vertexNormals.row(v)));
    least[v] = best > 0 ? std::min(minNormalAgreement, shareOfOwn * best) : 2;
  }
  return least;
}

void requireMoved(const ClosedSurface& reference, const Points& movedVertices) {
  if (movedVertices.rows() != reference.vertexCount())
    throw ArgumentError("Surface \"" + reference.name() + "\" has " +
                        std::to_string(reference.vertexCount()) +
                        " vertices, but the moved shape that is given as its own has " +
                        std::to_string(movedVertices.rows()) + " positions.");
  if (!movedVertices.allFinite())
    throw ArgumentError("Surface \"" + reference.name() +
                        "\" was moved to positions that are no finite numbers.");
}

/// locator: of the moved reference.
TransferredMap readOff(const MappedSurface& reference, const SurfaceLocator& locator,
                       const ClosedSurface& target) {
  const Points normals = vertexNormals(target.vertices(), target.faces());
  const std::vector<double> cosines = minCosines(target, normals);
  Points positions(target.vertexCount(), 3);
  std::vector<double> distances(cosines.size());
  int near = -1;  // vertices that follow each other are often neighbours
  for (int v = 0; v < target.vertexCount(); ++v) {
    SurfacePoint point;
    if (cosines[v] <= 1)
      point = locator.closest(target.vertex(v), normals.row(v).transpose(), cosines[v], near);
    if (point.face < 0) point = locator.closest(target.vertex(v), near);
    near = point.face;
    positions.row(v) = point.interpolate(reference.faces(), reference.positions()).transpose();
    distances[v] = point.distance;
  }
  Untangled untangled = mend(target, std::move(positions));  // which normalises first
  const Residual residual = residualOf(distances);
  return {std::move(untangled.map), untangled.repairedFaces, residual, std::move(distances)};
}

}  // namespace

TransferredMap transferMap(const MappedSurface& reference, const Points& movedVertices,
                           const ClosedSurface& target) {
  requireMoved(reference.surface(), movedVertices);
  return readOff(reference, SurfaceLocator(movedVertices, reference.faces()), target);
}

TransferredMap transferMap(const MappedSurface& reference, const Points& movedVertices,
                           const ClosedSurface& target, const std::vector<int>& order) {
  requireMoved(reference.surface(), movedVertices);
  return readOff(reference, SurfaceLocator(movedVertices, reference.faces(), order), target);
}

}  // namespace sphere_propagation
