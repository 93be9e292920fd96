// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/sphere_locator.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vcg_ext/sphere/ray_weights.h"

namespace sphere_propagation {
namespace {

// The boxes are larger than the triangles by far more than the rounding of a query (a few 1e-16 on
// the unit sphere), and by far less than the smallest faces (1e-14 steradian, 1e-7 across): no face
// that is hit is missed, and few others seen.
constexpr double margin = 1e-12;

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
  FaceTree::Four bounds(const FaceTree::Boxes& boxes) const {
    FaceTree::Four enter = FaceTree::Four::Zero(),
                   leave = FaceTree::Four::Constant(std::numeric_limits<double>::max());
    for (size_t axis = 0; axis < 3; ++axis) {
      const double factor = inverse[static_cast<Eigen::Index>(axis)];
      const FaceTree::Four t0 = boxes.low[axis] * factor, t1 = boxes.high[axis] * factor;
      enter = enter.max(t0.min(t1));
      leave = leave.min(t0.max(t1));
    }
    return (enter <= leave)
        .select(FaceTree::Four::Zero(),
                FaceTree::Four::Constant(std::numeric_limits<double>::infinity()));
  }

  double limit() const { return 0; }

  void visit(size_t i) {
    const FaceTree::Face& triangle = tree.faces()[i];
    const Vector3 w = rayWeights(triangle.corner[0], triangle.corner[1], triangle.corner[2], p);
    // Relative to the sum of the absolute values, which is positive also where the ray runs along
    // the face or behind it.
    const double score = w.minCoeff() / w.lpNorm<1>();
    if (score > best || (score == best && triangle.index < face)) {
      best = score;
      face = triangle.index;
      weights = w;
    }
  }
};

}  // namespace

SphereLocator::SphereLocator(const MappedSurface& surface)
    : tree_(surface.positions(), surface.faces(), margin) {}

SurfacePoint SphereLocator::locate(const Vector3& direction) const {
  RayQuery query(tree_, unitDirection(direction));
  tree_.search(query);
  // A valid map leaves no gap, and the boxes' margin no face unseen: rather an error than weights
  // that are no numbers.
  if (query.face < 0 || !(query.weights.maxCoeff() > 0))
    throw MapError("No face of a map was found under a direction.");
  return pointOfRay(query.face, query.weights);
}

}  // namespace sphere_propagation
