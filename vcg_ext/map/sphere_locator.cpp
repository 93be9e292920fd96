#include "vcg_ext/map/sphere_locator.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

// The boxes are larger than the triangles by far more than the rounding of a query (a few 1e-16 on the unit sphere),
// and by far less than the smallest faces (1e-14 steradian, 1e-7 across): no face that is hit is missed, and few others
// seen.
constexpr double margin = 1e-12;

double determinant(const Vector3& a, const Vector3& b, const Vector3& c) { return a.dot(b.cross(c)); }

struct RayQuery {
  const FaceTree& tree;
  Vector3 p;        // unit direction
  Vector3 inverse;  // of its coordinates, finite
  double best = -std::numeric_limits<double>::infinity();
  int face = -1;
  Vector3 weights = Vector3::Zero();

  RayQuery(const FaceTree& over, const Vector3& direction) : tree(over), p(direction) {
    constexpr double tiny = 1e-200;
    for (int k = 0; k < 3; ++k) inverse[k] = 1 / (std::fabs(p[k]) > tiny ? p[k] : tiny);
  }

  /// 0 where the ray from the centre meets the box, else infinity.
  double bound(const Vector3& low, const Vector3& high) const {
    const Vector3 t0 = low.cwiseProduct(inverse), t1 = high.cwiseProduct(inverse);
    const double enter = std::max(t0.cwiseMin(t1).maxCoeff(), 0.0), leave = t0.cwiseMax(t1).minCoeff();
    return enter <= leave ? 0 : std::numeric_limits<double>::infinity();
  }

  double limit() const { return 0; }

  void visit(size_t i) {
    // det(p, b, c) = det(p, b - p, c - p), and so on: differences keep the weights of small faces accurate.
    const FaceTree::Face& triangle = tree.faces()[i];
    const Vector3 a = triangle.corner[0] - p, b = triangle.corner[1] - p, c = triangle.corner[2] - p;
    const Vector3 w(determinant(p, b, c), determinant(p, c, a), determinant(p, a, b));
    // Relative to the sum of the absolute values, which is positive also where the ray runs along the face or behind
    // it.
    const double score = w.minCoeff() / w.lpNorm<1>();
    if (score > best || (score == best && triangle.index < face)) {
      best = score;
      face = triangle.index;
      weights = w;
    }
  }
};

}  // namespace

SphereLocator::SphereLocator(const ClosedSurface& surface, const SphereMap& map)
    : tree_(map.positions(), surface.faces(), margin) {}

SurfacePoint SphereLocator::locate(const Vector3& direction) const {
  const Vector3 p = direction.stableNormalized();
  if (!(std::fabs(p.squaredNorm() - 1) < 1e-6))
    throw ParameterError("A direction to locate on the sphere is zero or not finite.");
  RayQuery query(tree_, p);
  tree_.search(query);
  SurfacePoint found;
  found.face = query.face;
  found.weights = query.weights.cwiseMax(0.0);
  found.weights /= found.weights.sum();
  return found;
}

}  // namespace sphere_propagation
