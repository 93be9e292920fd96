// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A closed surface with a valid spherical parameterisation.

#include <memory>
#include <optional>
#include <utility>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/mesh/closed_surface.h"

namespace sphere_propagation {

/// A surface and one unit vector per vertex of it, certified: every spherical triangle is
/// positively oriented and together they cover the sphere once (certificate.h). What takes a
/// MappedSurface need not check again, and cannot be handed the map of another surface.
///
/// Immutable, and cheap to copy: copies share what they hold.
class MappedSurface {
 public:
  /// surface: what is mapped; positions: #V by 3 unit vectors.
  /// Throws MapError, which names the surface and the reason, when the positions do not certify.
  MappedSurface(ClosedSurface surface, Points positions);

  /// The same, but nothing where the positions do not certify.
  static std::optional<MappedSurface> ifValid(ClosedSurface surface, Points positions);

  /// The map of a surface with the same faces, as the moved one is: validity is a matter of the
  /// faces and the positions alone. Throws ParameterError when the faces are others.
  MappedSurface of(ClosedSurface surface) const;

  const ClosedSurface& surface() const { return surface_; }
  const Triangles& faces() const { return surface_.faces(); }
  int vertexCount() const { return surface_.vertexCount(); }

  const Points& positions() const { return *positions_; }
  Vector3 position(int v) const { return positions_->row(v).transpose(); }

 private:
  MappedSurface(ClosedSurface surface, std::shared_ptr<const Points> certified)
      : surface_(std::move(surface)), positions_(std::move(certified)) {}

  ClosedSurface surface_;
  std::shared_ptr<const Points> positions_;
};

}  // namespace sphere_propagation
