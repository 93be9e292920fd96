#include "vcg_ext/propagation/layer_poses.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "vcg_ext/propagation/shape_alignment.h"

namespace sphere_propagation {
namespace {

constexpr double nearEnough = 0.05;  // in R
constexpr double farBetter = 1.6;

RigidMotion inverse(const RigidMotion& motion) {
  const Eigen::Matrix3d back = motion.rotation.transpose();
  return {back, -back * motion.translation};
}

/// First the second, then the first.
RigidMotion operator*(const RigidMotion& a, const RigidMotion& b) {
  return {a.rotation * b.rotation, a.rotation * b.translation + a.translation};
}

ClosedSurface mirrorImage(const ClosedSurface& surface) {
  Points vertices = surface.vertices();
  vertices.col(0) = -vertices.col(0);
  Triangles faces = surface.faces();
  faces.col(1).swap(faces.col(2));
  return {vertices, faces, surface.name()};
}

/// The pose relative to a layer that lies well, `as` moved by asToRoot.
LayerPose findPose(const AlignedShape& shape, const AlignedShape& as, const RigidMotion& asToRoot) {
  // As it lies, or where that one was laid: what was moved with it needs no pose of its own.
  LayerPose pose;
  double distance = shapeDistance(shape, as, inverse(asToRoot));
  const double beside = shapeDistance(shape, as);
  if (beside < distance) {
    distance = beside;
    pose.toRoot = asToRoot;
  }
  if (distance > nearEnough * as.radius()) {
    const RigidMotion found = motionFromAnywhere(shape, as);
    if (distance > farBetter * shapeDistance(shape, as, found)) {
      pose.moved = true;
      pose.toRoot = asToRoot * found;
    }
  }
  return pose;
}

bool isMirrored(const ClosedSurface& surface, const AlignedShape& shape, const LayerPose& pose, const AlignedShape& as,
                const RigidMotion& asToRoot) {
  const double distance = shapeDistance(shape, as, inverse(asToRoot) * pose.toRoot);
  if (distance <= nearEnough * as.radius()) return false;
  const AlignedShape mirrored(mirrorImage(surface));
  return distance > farBetter * shapeDistance(mirrored, as, motionFromAnywhere(mirrored, as));
}

}  // namespace

std::vector<LayerPose> findLayerPoses(const std::vector<ClosedSurface>& surfaces, const PropagationTree& tree,
                                      ThreadPool& pool) {
  const std::vector<AlignedShape> shapes = alignedShapes(surfaces, pool);
  std::vector<LayerPose> poses(surfaces.size());
  const std::vector<std::vector<int>> levels = tree.levels();
  const auto find = [&](int t) {
    const int s = tree.parent[static_cast<size_t>(t)];
    const auto i = static_cast<size_t>(t);
    // A parent that was moved lies as well as its alignment made it; an ancestor that was not may tell more.
    int ancestor = s;
    while (poses[static_cast<size_t>(ancestor)].moved) ancestor = tree.parent[static_cast<size_t>(ancestor)];
    const auto near = static_cast<size_t>(s), far = static_cast<size_t>(ancestor);
    LayerPose& pose = poses[i];
    pose = findPose(shapes[i], shapes[far], poses[far].toRoot);
    const AlignedShape* as = &shapes[far];
    const RigidMotion* asToRoot = &poses[far].toRoot;
    if (pose.moved && near != far) {
      as = &shapes[near];
      asToRoot = &poses[near].toRoot;
      pose = findPose(shapes[i], *as, *asToRoot);
    }
    pose.mirrored = isMirrored(surfaces[i], shapes[i], pose, *as, *asToRoot);
    const Vector3& centre = shapes[i].centre();
    pose.shift = (pose.toRoot.rotation * centre + pose.toRoot.translation - centre).norm();
    pose.angle = Eigen::AngleAxisd(pose.toRoot.rotation).angle() * 180 / pi;
  };
  for (size_t level = 1; level < levels.size(); ++level)
    pool.forEach(static_cast<int>(levels[level].size()), [&](int k) { find(levels[level][static_cast<size_t>(k)]); });
  return poses;
}

ClosedSurface movedSurface(const ClosedSurface& surface, const RigidMotion& motion) {
  return {motion.applyTo(surface.vertices()), surface.faces(), surface.name()};
}

}  // namespace sphere_propagation
