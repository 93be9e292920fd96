// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Geometry of triangles on the unit sphere, and tangent frames: what the algorithms that move
/// vertices over the sphere share. (The certificate deliberately has its own.)

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// 2 atan2(n, d). Faces of fine meshes are small, where the series is exact to the last bits and
/// several times quicker.
inline double twiceAngle(double n, double d) {
  const double t = n / d, t2 = t * t;
  if (d > 0 && t2 < 1e-3)
    return 2 * t *
           (1 -
            t2 * (1.0 / 3 - t2 * (1.0 / 5 - t2 * (1.0 / 7 - t2 * (1.0 / 9 - t2 * (1.0 / 11))))));
  return 2 * std::atan2(n, d);
}

/// Signed solid angle (steradian, in (-2 pi, 2 pi]) of the spherical triangle of unit vectors a, b,
/// c; positive when they run counter-clockwise seen from outside. A. van Oosterom and J. Strackee,
/// 1983; differences keep small triangles exact.
inline double solidAngle(const Vector3& a, const Vector3& b, const Vector3& c) {
  const Vector3 e = b - a, g = c - a;
  return twiceAngle(a.dot(e.cross(g)), 1 + a.dot(b) + b.dot(c) + c.dot(a));
}

/// The same, and its gradient with respect to each corner (tangential part).
inline double solidAngle(const std::array<Vector3, 3>& p, std::array<Vector3, 3>& gradient) {
  const Vector3 &a = p[0], &b = p[1], &c = p[2];
  const Vector3 e = b - a, g = c - a;
  const double n = a.dot(e.cross(g)), d = 1 + a.dot(b) + b.dot(c) + c.dot(a),
               factor = 2 / (n * n + d * d);
  gradient[0] = factor * (d * b.cross(c) - n * (b + c));
  gradient[1] = factor * (d * c.cross(a) - n * (c + a));
  gradient[2] = factor * (d * a.cross(b) - n * (a + b));
  return twiceAngle(n, d);
}

/// The corners of a regular tetrahedron on the sphere; the second to the fourth run
/// counter-clockwise round the first.
inline Eigen::Matrix<double, 4, 3> regularTetrahedron() {
  Eigen::Matrix<double, 4, 3> corners;
  corners << 1, 1, 1, -1, -1, 1, 1, -1, -1, -1, 1, -1;
  return corners / std::sqrt(3.0);
}

/// Right-handed orthonormal frame (t1, t2, x) at the unit vector x, without branches on its
/// direction (T. Duff et al., Building an orthonormal basis, revisited, 2017).
inline void tangentFrame(const Vector3& x, Vector3& t1, Vector3& t2) {
  const double s = std::copysign(1.0, x[2]), a = -1 / (s + x[2]), b = x[0] * x[1] * a;
  t1 = Vector3(1 + s * x[0] * x[0] * a, s * b, -s * x[0]);
  t2 = Vector3(b, s + x[1] * x[1] * a, -x[1]);
}

}  // namespace sphere_propagation
