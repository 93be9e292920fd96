// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/sphere_walk.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "vcg_ext/sphere/ray_weights.h"

namespace sphere_propagation {
namespace {

// A face's weights are off by less than this times the square of the distance of its farthest
// corner; a direction that lies deeper inside is in no other face.
constexpr double rounding = 1e-12;

struct Arrival {
  int face;
  Vector3 weights;
  bool inside;  ///< or where rounding decides
};

Arrival walk(const MappedSurface& mapped, const Vector3& p, int face) {
  const ClosedSurface& surface = mapped.surface();
  const Triangles& faces = surface.faces();
  const auto corner = [&](int f, int k) { return mapped.position(faces(f, k)); };
  const int steps = 16 + 4 * static_cast<int>(std::sqrt(static_cast<double>(surface.faceCount())));
  Vector3 weights;
  for (int i = 0;; ++i) {
    weights = rayWeights(corner(face, 0), corner(face, 1), corner(face, 2), p);
    int least = 0;
    if (!(weights.minCoeff(&least) < 0)) return {face, weights, true};
    if (i == steps) return {face, weights, false};
    face = surface.twin(3 * face + (least + 1) % 3) / 3;  // across the side opposite that corner
  }
}

}  // namespace

int walkOverSphere(const MappedSurface& surface, const Vector3& direction, int start) {
  return walk(surface, direction, start).face;
}

SphereWalk::SphereWalk(MappedSurface surface) : surface_(std::move(surface)) {}

SurfacePoint SphereWalk::locate(const Vector3& direction) {
  const Vector3 p = unitDirection(direction);
  const Arrival arrival = walk(surface_, p, at_);
  at_ = arrival.face;
  double farthest = 0;
  for (int k = 0; k < 3; ++k)
    farthest = std::max(farthest, (surface_.position(surface_.faces()(at_, k)) - p).squaredNorm());
  if (arrival.inside && arrival.weights.minCoeff() > rounding * farthest)
    return pointOfRay(at_, arrival.weights);
  if (!locator_) locator_.emplace(surface_);
  SurfacePoint found = locator_->locate(direction);
  at_ = found.face;
  return found;
}

std::vector<int> facesUnder(const MappedSurface& map,
                            const std::function<int(const Vector3&, int)>& walk) {
  const ClosedSurface& surface = map.surface();
  std::vector<int> under(static_cast<size_t>(surface.vertexCount()), -1);
  for (int v = 0; v < surface.vertexCount(); ++v) {
    int start = v > 0 ? under[static_cast<size_t>(v - 1)] : 0;
    for (const int neighbour : surface.ring(v))
      if (neighbour < v) {
        start = under[static_cast<size_t>(neighbour)];
        break;
      }
    under[static_cast<size_t>(v)] = walk(map.position(v), start);
  }
  return under;
}

}  // namespace sphere_propagation
