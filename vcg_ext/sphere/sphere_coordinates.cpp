// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/sphere_coordinates.h"

#include <cmath>

namespace sphere_propagation {
Vector2 textureCoordinate(const Vector3& p) {
  const double across = std::hypot(p[0], p[1]);
  double u = across > 0 ? std::atan2(p[1], p[0]) / (2 * pi) : 0;
  if (u < 0) u += 1;
  if (u >= 1) u = 0;  // a tiny negative longitude rounds to the full turn
  return {u, std::atan2(across, p[2]) / pi};
}

Vector3 spherePosition(const Vector2& t) {
  const double longitude = 2 * pi * t[0], colatitude = pi * t[1], s = std::sin(colatitude);
  return {s * std::cos(longitude), s * std::sin(longitude), std::cos(colatitude)};
}

}  // namespace sphere_propagation
