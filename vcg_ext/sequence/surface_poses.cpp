// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/surface_poses.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "vcg_ext/registration/shape_alignment.h"

namespace sphere_propagation {
namespace {

constexpr double nearEnough = 0.05;  // in R
constexpr double farBetter = 1.6;

/// Whether another pose could fit far better than the shape does at this distance.
bool mayFitFarBetter(const PreparedSurface& shape, const PreparedSurface& as, double distance) {
  return distance > nearEnough * as.radius() && distance > farBetter * minShapeDistance(shape, as);
}

struct FoundPose {
  SurfacePose pose;
  double distance;  // of the shapes, so laid
};

/// As it lies, or where another one was laid: what was moved with that needs no pose of its own.
FoundPose poseAsItLies(const PreparedSurface& shape, const PreparedSurface& as,
                       const RigidMotion& asToRoot) {
  FoundPose found{{}, shapeDistance(shape, as, asToRoot.inverse())};
  if (!asToRoot.isIdentity()) {
    const double beside = shapeDistance(shape, as);
    if (beside < found.distance) {
      found.distance = beside;
      found.pose.toRoot = asToRoot;
    }
  }
  return found;
}

/// The pose relative to a surface that lies well, `as` moved by asToRoot.
FoundPose findPose(const PreparedSurface& shape, const PreparedSurface& as,
                   const RigidMotion& asToRoot) {
  FoundPose found = poseAsItLies(shape, as, asToRoot);
  if (mayFitFarBetter(shape, as, found.distance)) {
    const RigidMotion motion = motionFromAnywhere(shape, as);
    const double distance = shapeDistance(shape, as, motion);
    if (found.distance > farBetter * distance) {
      found.distance = distance;
      found.pose.moved = true;
      found.pose.toRoot = asToRoot * motion;
    }
  }
  return found;
}

void measure(SurfacePose& pose, const PreparedSurface& shape) {
  const Vector3& centre = shape.centre();
  pose.shift = (pose.toRoot.rotation * centre + pose.toRoot.translation - centre).norm();
  pose.angle = Eigen::AngleAxisd(pose.toRoot.rotation).angle() * 180 / pi;
}

}  // namespace

std::vector<SurfacePose> posesByAnchors(const Sequence& sequence, int root,
                                        const std::vector<Points>& anchors) {
  std::vector<SurfacePose> poses(static_cast<size_t>(sequence.size()));
  for (size_t i = 0; i < anchors.size(); ++i) {
    if (i == static_cast<size_t>(root)) continue;
    const std::optional<RigidMotion> motion =
        fitRigidWhereShared(anchors[i], anchors[static_cast<size_t>(root)]);
    if (!motion) continue;
    poses[i].toRoot = *motion;
    poses[i].byAnchors = true;
    measure(poses[i], sequence[static_cast<int>(i)]);
  }
  return poses;
}

std::vector<SurfacePose> findSurfacePoses(const Sequence& sequence, const PropagationTree& tree,
                                          ThreadPool& pool, const std::vector<SurfacePose>& known) {
  sequence.prepare(pool);
  std::vector<SurfacePose> poses(static_cast<size_t>(sequence.size()));
  const std::vector<std::vector<int>> levels = tree.levels();
  const auto find = [&](int t) {
    const int s = tree.parent[static_cast<size_t>(t)];
    const auto i = static_cast<size_t>(t);
    const PreparedSurface& shape = sequence[t];
    if (!known.empty() && known[i].byAnchors) {
      poses[i] = known[i];
      return;
    }
    // A parent that was moved lies as well as its alignment made it; an ancestor that was not may
    // tell more.
    int ancestor = s;
    while (poses[static_cast<size_t>(ancestor)].moved)
      ancestor = tree.parent[static_cast<size_t>(ancestor)];
    const auto near = static_cast<size_t>(s), far = static_cast<size_t>(ancestor);
    FoundPose found = findPose(shape, sequence[ancestor], poses[far].toRoot);
    if (found.pose.moved && near != far) found = findPose(shape, sequence[s], poses[near].toRoot);
    // Behind a surface that does not belong to the others: where one farther up fits as this one
    // lies, it lies well.
    for (int a = tree.parent[far]; found.pose.moved && a >= 0;
         a = tree.parent[static_cast<size_t>(a)]) {
      const auto up = static_cast<size_t>(a);
      const FoundPose lies = poseAsItLies(shape, sequence[a], poses[up].toRoot);
      if (!mayFitFarBetter(shape, sequence[a], lies.distance)) found = lies;
    }
    poses[i] = found.pose;
    measure(poses[i], shape);
  };
  for (size_t level = 1; level < levels.size(); ++level)
    pool.forEach(static_cast<int>(levels[level].size()),
                 [&](int k) { find(levels[level][static_cast<size_t>(k)]); });
  return poses;
}

Sequence laidInRootsFrame(const Sequence& sequence, const std::vector<SurfacePose>& poses) {
  Sequence laid = sequence;
  for (int i = 0; i < sequence.size(); ++i) {
    const RigidMotion& motion = poses[static_cast<size_t>(i)].toRoot;
    if (motion.isIdentity()) continue;
    const ClosedSurface& surface = sequence.surface(i);
    laid = laid.with(i, surface.withVertices(motion.applyTo(surface.vertices())));
  }
  return laid;
}

}  // namespace sphere_propagation
