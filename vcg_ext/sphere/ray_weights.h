// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Where a ray from the centre of the sphere pierces a flat triangle: what the ways to locate a
/// direction share.

#include <Eigen/Geometry>
#include <cmath>

#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/surface_locator.h"

namespace sphere_propagation {

/// Weights of the corners a, b, c, up to a factor: all positive where the ray along the unit vector
/// p passes inside a triangle that is seen counter-clockwise from outside. det(p, b, c) = det(p, b
/// - p, c - p), and so on: differences keep the weights of small faces accurate.
inline Vector3 rayWeights(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& p) {
  const Vector3 e = a - p, f = b - p, g = c - p;
  return {p.dot(f.cross(g)), p.dot(g.cross(e)), p.dot(e.cross(f))};
}

/// The unit vector along a direction. Throws ParameterError when it is zero or not finite.
inline Vector3 unitDirection(const Vector3& direction) {
  Vector3 p = direction.stableNormalized();
  if (!(std::fabs(p.squaredNorm() - 1) < 1e-6))
    throw ArgumentError("A direction to locate on the sphere is zero or not finite.");
  return p;
}

/// The point of a face with these weights, which rounding may have left a little below zero, and of
/// any sum.
inline SurfacePoint pointOfRay(int face, const Vector3& weights) {
  SurfacePoint found;
  found.face = face;
  found.weights = weights.cwiseMax(0.0);
  found.weights /= found.weights.sum();
  return found;
}

}  // namespace sphere_propagation
