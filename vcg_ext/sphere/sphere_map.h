// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A valid spherical parameterisation of a closed surface.

#include <optional>
#include <utility>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/mesh/closed_surface.h"

namespace sphere_propagation {

/// One unit vector per vertex of a surface, certified: every spherical triangle is positively
/// oriented and together they cover the sphere once (see certificate.h). What takes a SphereMap
/// need not check again.
class SphereMap {
 public:
  /// surface: the surface that is mapped; positions: #V by 3 unit vectors.
  /// Throws MapError, which names the surface and the reason, when the positions do not certify.
  SphereMap(const ClosedSurface& surface, Points positions);

  /// The same, but nothing where the positions do not certify.
  static std::optional<SphereMap> ifValid(const ClosedSurface& surface, Points positions);

  const Points& positions() const { return positions_; }
  Vector3 position(int v) const { return positions_.row(v).transpose(); }

 private:
  explicit SphereMap(Points certified) : positions_(std::move(certified)) {}

  Points positions_;
};

}  // namespace sphere_propagation
