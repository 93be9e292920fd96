// SPDX-License-Identifier: GPL-3.0-only
// Closest point on a triangle: C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5. The
// areas are taken from cross products instead of his products of dot products, which lose twice as
// many digits on thin triangles.

#include "vcg_ext/mesh/surface_locator.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace sphere_propagation {
namespace {

using Corners = std::array<Vector3, 3>;

/// Unit normal; zero for a triangle that is a segment or a point up to rounding.
Vector3 unitNormal(const Corners& t) {
  constexpr double flat = 1e-12;  // height over length
  const Vector3 e = t[1] - t[0], g = t[2] - t[0], n = e.cross(g);
  const double length = n.norm();
  const double longest = std::max({e.squaredNorm(), g.squaredNorm(), (t[2] - t[1]).squaredNorm()});
  return length > flat * longest ? Vector3(n / length) : Vector3(Vector3::Zero());
}

/// Weights of the point of a triangle without area that is closest to the origin: on one of its
/// sides.
Vector3 closestOnSides(const Corners& t) {
  Vector3 best = Vector3::UnitX();
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    const Vector3 &a = t[static_cast<size_t>(k)], &b = t[static_cast<size_t>(next)];
    const double length = (b - a).squaredNorm();
    const double s = length > 0 ? std::clamp(-a.dot(b - a) / length, 0.0, 1.0) : 0;
    const double distance = ((1 - s) * a + s * b).squaredNorm();
    if (distance < least) {
      least = distance;
      best.setZero();
      best[k] = 1 - s;
      best[next] = s;
    }
  }
  return best;
}

/// Weights of the point of the triangle with this unit normal that is closest to the origin.
Vector3 closestInTriangle(const Corners& t, const Vector3& normal) {
  if (normal.isZero(0)) return closestOnSides(t);
  const Vector3 &a = t[0], &b = t[1], &c = t[2];
  const Vector3 ab = b - a, ac = c - a;
  const double d1 = -ab.dot(a), d2 = -ac.dot(a);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const double d3 = -ab.dot(b), d4 = -ac.dot(b);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double d5 = -ab.dot(c), d6 = -ac.dot(c);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double areaC = normal.dot(a.cross(b));
  if (areaC <= 0 && d1 >= 0 && d3 <= 0) {
    const double s = d1 / (d1 - d3);
    return {1 - s, s, 0};
  }
  const double areaB = normal.dot(c.cross(a));
  if (areaB <= 0 && d2 >= 0 && d6 <= 0) {
    const double s = d2 / (d2 - d6);
    return {1 - s, 0, s};
  }
  const double areaA = normal.dot(b.cross(c));
  if (areaA <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double s = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - s, s};
  }
  const Vector3 areas(std::max(areaA, 0.0), std::max(areaB, 0.0), std::max(areaC, 0.0));
  const double sum = areas.sum();
  return sum > 0 ? Vector3(areas / sum) : closestOnSides(t);
}

struct ClosestQuery {
  const FaceTree& tree;
  const std::vector<Vector3>& normals;
  Vector3 x;
  const Vector3* direction;  // null: any face will do
  double minCosine;
  double least = std::numeric_limits<double>::infinity();  // squared distance of the best so far
  SurfacePoint best = {};

  FaceTree::Four bounds(const FaceTree::Boxes& boxes) const {
    const auto along = [&](size_t axis) -> FaceTree::Four {
      const double at = x[static_cast<Eigen::Index>(axis)];
      return (boxes.low[axis] - at).max(at - boxes.high[axis]).max(0.0).square();
    };
    return along(0) + along(1) + along(2);
  }

  // With some slack: a box that rounding puts just beyond the best may hold a face that rounding
  // puts just before it.
  double limit() const { return least * (1 + 1e-12); }

  void visit(size_t i) {
    const FaceTree::Face& face = tree.faces()[i];
    const Vector3& normal = normals[i];
    if (direction && (normal.isZero(0) || !(normal.dot(*direction) >= minCosine))) return;
    const Corners t{face.corner[0] - x, face.corner[1] - x, face.corner[2] - x};
    const Vector3 weights = closestInTriangle(t, normal);
    const double distance =
        (weights[0] * t[0] + weights[1] * t[1] + weights[2] * t[2]).squaredNorm();
    if (distance < least || (distance == least && face.index < best.face)) {
      least = distance;
      best.face = face.index;
      best.weights = weights;
    }
  }

  SurfacePoint answer() {
    tree.search(*this);
    best.distance = best.face >= 0 ? std::sqrt(least) : 0;
    return best;
  }
};

}  // namespace

SurfaceLocator::SurfaceLocator(const Points& vertices, const Triangles& faces)
    : tree_(vertices, faces) {
  orderFaces();
}

SurfaceLocator::SurfaceLocator(const Points& vertices, const Triangles& faces,
                               const std::vector<int>& order)
    : tree_(vertices, faces, order) {
  orderFaces();
}

std::vector<int> SurfaceLocator::order() const {
  std::vector<int> faces;
  faces.reserve(tree_.faces().size());
  for (const FaceTree::Face& face : tree_.faces()) faces.push_back(face.index);
  return faces;
}

void SurfaceLocator::orderFaces() {
  normals_.reserve(tree_.faces().size());
  places_.resize(tree_.faces().size());
  for (const FaceTree::Face& face : tree_.faces()) {
    places_[static_cast<size_t>(face.index)] = normals_.size();
    normals_.push_back(unitNormal(face.corner));
  }
}

SurfacePoint SurfaceLocator::closest(const Vector3& x, int near) const {
  ClosestQuery query{tree_, normals_, x, nullptr, 0};
  if (near >= 0) query.visit(places_[static_cast<size_t>(near)]);
  return query.answer();
}

SurfacePoint SurfaceLocator::closest(const Vector3& x, const Vector3& direction, double minCosine,
                                     int near) const {
  ClosestQuery query{tree_, normals_, x, &direction, minCosine};
  if (near >= 0) query.visit(places_[static_cast<size_t>(near)]);
  return query.answer();
}

}  // namespace sphere_propagation
