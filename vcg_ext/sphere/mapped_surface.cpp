// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/mapped_surface.h"

#include <cmath>
#include <string>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation {
namespace {

void requireOnePerVertex(const ClosedSurface& surface, const Points& positions) {
  if (positions.rows() == surface.vertexCount()) return;
  throw MapError(Finding(Fault::PositionCount, surface.name())
                     .of(positions.rows())
                     .amid(surface.vertexCount()));
}

void requireValid(const ClosedSurface& surface, const Certificate& certificate) {
  if (certificate.valid()) return;
  // Vertices off the sphere and flipped faces are counted apart: the former come first.
  if (certificate.notOnSphere > 0)
    throw MapError(Finding(Fault::NotOnSphere, surface.name())
                       .of(certificate.notOnSphere, certificate.firstNotOnSphere));
  if (certificate.flippedFaces > 0)
    throw MapError(Finding(Fault::FlippedFaces, surface.name())
                       .of(certificate.flippedFaces, certificate.firstFlippedFace));
  throw MapError(
      Finding(Fault::NotCoveredOnce, surface.name()).of(std::lround(certificate.degree)));
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
    throw ArgumentError("The map of surface \"" + surface_.name() + "\" is none of surface \"" +
                        surface.name() + "\": their faces differ.");
  return {std::move(surface), positions_};
}

}  // namespace sphere_propagation
