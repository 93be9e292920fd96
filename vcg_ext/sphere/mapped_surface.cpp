// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/mapped_surface.h"

#include <string>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation {
namespace {

void requireOnePerVertex(const ClosedSurface& surface, const Points& positions) {
  if (positions.rows() == surface.vertexCount()) return;
  throw MapError(positions.rows(), -1,
                 "Layer \"" + surface.name() + "\": " + std::to_string(positions.rows()) +
                     " sphere positions for " + std::to_string(surface.vertexCount()) +
                     " vertices.");
}

void requireValid(const ClosedSurface& surface, const Certificate& certificate) {
  if (certificate.valid()) return;
  // Vertices off the sphere and flipped faces are counted apart: the former come first.
  const bool off = certificate.notOnSphere > 0;
  throw MapError(
      off ? certificate.notOnSphere : certificate.flippedFaces,
      off ? certificate.firstNotOnSphere : certificate.firstFlippedFace,
      "Layer \"" + surface.name() +
          "\": its map to the sphere is not valid: " + certificate.reason() + ".");
}

}  // namespace

MappedSurface::MappedSurface(ClosedSurface surface, Points positions)
    : surface_(std::move(surface)) {
  requireOnePerVertex(surface_, positions);
  requireValid(surface_, certify(surface_.faces(), positions));
  positions_ = std::make_shared<const Points>(std::move(positions));
}

std::optional<MappedSurface> MappedSurface::ifValid(ClosedSurface surface, Points positions) {
  if (positions.rows() != surface.vertexCount() || !certify(surface.faces(), positions).valid())
    return std::nullopt;
  return MappedSurface(std::move(surface), std::make_shared<const Points>(std::move(positions)));
}

MappedSurface MappedSurface::of(ClosedSurface surface) const {
  if (!surface.hasFacesOf(surface_))
    throw ParameterError("The map of surface \"" + surface_.name() + "\" is none of surface \"" +
                         surface.name() + "\": their faces differ.");
  return {std::move(surface), positions_};
}

}  // namespace sphere_propagation
