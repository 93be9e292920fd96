// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/kernel_placement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "vcg_ext/sphere/admissible.h"
#include "vcg_ext/sphere/spherical_triangle.h"

namespace sphere_propagation {
namespace {

using Polygon = std::vector<Vector2>;

/// Cuts off what has a + n.p < 0.
void cut(Polygon& polygon, double a, const Vector2& n, Polygon& scratch) {
  scratch.clear();
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vector2 &p = polygon[i], &q = polygon[i + 1 == polygon.size() ? 0 : i + 1];
    const double atP = a + n.dot(p), atQ = a + n.dot(q);
    if (atP >= 0) scratch.push_back(p);
    if ((atP >= 0) != (atQ >= 0)) scratch.push_back(p + atP / (atP - atQ) * (q - p));
  }
  polygon.swap(scratch);
}

/// False when the polygon has no area.
bool centroid(const Polygon& polygon, Vector2& centre) {
  double area = 0;
  centre.setZero();
  for (size_t i = 1; i + 1 < polygon.size(); ++i) {
    const Vector2 e = polygon[i] - polygon[0], g = polygon[i + 1] - polygon[0];
    const double a = e[0] * g[1] - e[1] * g[0];
    area += a;
    centre += a / 3 * (e + g);
  }
  if (!(area > 0)) return false;
  centre = polygon[0] + centre / area;
  return true;
}

bool placeNear(const std::vector<Vector3>& rim, const Vector3& near, double minAngle, Vector3& x) {
  Vector3 t1, t2;
  tangentFrame(near, t1, t2);
  constexpr double largest = 4;
  double window = 0;
  for (const Vector3& p : rim) {
    const double cosine = p.dot(near);
    window = std::max(window, cosine > 0.3 ? (p - near).norm() / cosine : largest);
  }
  window = std::min(window, largest);
  Polygon polygon, scratch;
  for (int i = 0; i < 16; ++i, window *= 0.3) {
    polygon = {{-window, -window}, {window, -window}, {window, window}, {-window, window}};
    for (size_t j = 0; j < rim.size() && polygon.size() > 2; ++j) {
      const Vector3 &b = rim[j], &c = rim[j + 1 == rim.size() ? 0 : j + 1];
      const Vector3 n = b.cross(c - b);
      const double length = n.norm();
      if (!(length > 0)) continue;
      const bool through = b == near || c == near;  // exactly
      cut(polygon, through ? 0 : n.dot(near) / length, Vector2(n.dot(t1), n.dot(t2)) / length,
          scratch);
    }
    Vector2 centre;
    if (polygon.size() < 3 || !centroid(polygon, centre)) continue;
    x = (near + centre[0] * t1 + centre[1] * t2).normalized();
    if (minSolidAngle(rim, x) >= minAngle) return true;
  }
  return false;
}

}  // namespace

double minSolidAngle(const std::vector<Vector3>& rim, const Vector3& x) {
  double least = Admissible::maxSolidAngle;
  for (size_t i = 0; i < rim.size(); ++i) {
    const Vector3 &b = rim[i], &c = rim[i + 1 == rim.size() ? 0 : i + 1];
    if (x.dot(b) < Admissible::minCosine) return -1;
    const double s = solidAngle(x, b, c);
    if (!(s > 0 && s <= Admissible::maxSolidAngle)) return -1;
    least = std::min(least, s);
  }
  return least;
}

bool placeInKernel(const std::vector<Vector3>& rim, const Vector3& near, double minAngle,
                   Vector3& x) {
  if (placeNear(rim, near, minAngle, x)) return true;
  Vector3 mean = Vector3::Zero();
  for (const Vector3& p : rim) mean += p;
  if (mean.norm() > 0 && placeNear(rim, mean.normalized(), minAngle, x)) return true;
  for (const Vector3& p : rim)
    if (placeNear(rim, p, minAngle, x)) return true;
  return false;
}

}  // namespace sphere_propagation
