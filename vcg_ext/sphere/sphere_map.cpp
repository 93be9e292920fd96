// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/sphere_map.h"

#include <utility>

#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation {

SphereMap::SphereMap(const ClosedSurface& surface, Points positions)
    : positions_(std::move(positions)) {
  if (positions_.rows() != surface.vertexCount())
    throw MapError(positions_.rows(), -1,
                   "Layer \"" + surface.name() + "\": " + std::to_string(positions_.rows()) +
                       " sphere positions for " + std::to_string(surface.vertexCount()) +
                       " vertices.");
  const Certificate certificate = certify(surface.faces(), positions_);
  if (!certificate.valid())
    throw MapError(
        certificate.notOnSphere + certificate.flippedFaces,
        certificate.notOnSphere > 0 ? certificate.firstNotOnSphere : certificate.firstFlippedFace,
        "Layer \"" + surface.name() +
            "\": its map to the sphere is not valid: " + certificate.reason() + ".");
}

std::optional<SphereMap> SphereMap::ifValid(const ClosedSurface& surface, Points positions) {
  if (positions.rows() != surface.vertexCount() || !certify(surface.faces(), positions).valid())
    return std::nullopt;
  return SphereMap(std::move(positions));
}

}  // namespace sphere_propagation
