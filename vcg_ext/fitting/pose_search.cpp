// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/fitting/pose_search.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "vcg_ext/base/statistics.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/registration/pose_starts.h"

namespace sphere_propagation {
namespace {

constexpr int samplesUsed = 100, steps = 12;
constexpr double trimmed = 0.7;        // the share of the samples that is fitted
constexpr double agreementHere = 0.3;  // of normals: poses are rough
constexpr double distinct = 0.3;       // norm of the difference of two rotations
// Of a step, per sample: what a surface hardly tells, as the turn of a body of revolution about its
// axis, is not to be told by noise.
constexpr double damping = 1e-2;

struct Samples {
  Points points, normals;
};

Samples someOf(const FittingTarget& target) {
  const Eigen::Index count = std::min<Eigen::Index>(samplesUsed, target.samples().rows());
  Samples some{Points(count, 3), Points(count, 3)};
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index at = i * target.samples().rows() / count;
    some.points.row(i) = target.samples().row(at);
    some.normals.row(i) = target.sampleNormals().row(at);
  }
  return some;
}

/// From the surface to the model.
StartPose fitFrom(const Samples& samples, const FittingModel& model, const SurfaceLocator& mean,
                  const Points& faceNormals, RigidMotion pose) {
  const Eigen::Index count = samples.points.rows();
  const double far = model.radius();
  std::vector<double> distances(static_cast<size_t>(count));
  std::vector<int> nearby(distances.size(), -1);  // faces found the last time, to look at first
  for (int step = 0; step < steps; ++step) {
    const Points x = pose.applyTo(samples.points), m = samples.normals * pose.rotation.transpose();
    Points feet(count, 3), normals(count, 3);
    for (Eigen::Index i = 0; i < count; ++i) {
      const Vector3 point = x.row(i).transpose();
      int& near = nearby[static_cast<size_t>(i)];
      SurfacePoint foot = mean.closest(point, m.row(i).transpose(), agreementHere, near);
      double beyond = 0;
      if (foot.face < 0) {
        foot = mean.closest(point, near);
        beyond = far;
      }
      near = foot.face;
      feet.row(i) = foot.interpolate(model.faces(), model.mean()).transpose();
      normals.row(i) = faceNormals.row(foot.face);
      distances[static_cast<size_t>(i)] = foot.distance + beyond;
    }
    const double limit = lowerQuantileOf(distances, trimmed);
    Eigen::Matrix<double, 6, 6> h = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> v = Eigen::Matrix<double, 6, 1>::Zero();
    Vector3 centre = Vector3::Zero();
    double near = 0;
    for (Eigen::Index i = 0; i < count; ++i)
      if (distances[static_cast<size_t>(i)] <= limit) {
        centre += x.row(i).transpose();
        ++near;
      }
    centre /= near;
    for (Eigen::Index i = 0; i < count; ++i) {
      if (distances[static_cast<size_t>(i)] > limit) continue;
      const Vector3 n = normals.row(i).transpose(), arm = x.row(i).transpose() - centre;
      Eigen::Matrix<double, 6, 1> g;
      g << arm.cross(n) / far, n;
      h += g * g.transpose();
      v += g * n.dot((feet.row(i) - x.row(i)).transpose());
    }
    h.diagonal().array() += damping * near;
    const Eigen::Matrix<double, 6, 1> d = h.llt().solve(v);
    const Vector3 turn = d.head<3>() / far;
    const double angle = turn.norm();
    const Eigen::Matrix3d rotation = angle > 0
                                         ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix()
                                         : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
    pose = RigidMotion{rotation, centre + d.tail<3>() - rotation * centre} * pose;
    if (angle < 1e-4 && d.tail<3>().norm() < 1e-4 * far) break;
  }
  std::sort(distances.begin(), distances.end());
  const auto kept = static_cast<size_t>(trimmed * static_cast<double>(distances.size()));
  double sum = 0;
  for (size_t i = 0; i < kept; ++i) sum += distances[i];
  return {pose.inverse(), kept > 0 ? sum / static_cast<double>(kept) : 0};
}

}  // namespace

std::vector<RigidMotion> turnsAboutCentre(const FittingModel& model, const FittingTarget& target) {
  const Vector3 centre = model.mean().colwise().mean().transpose();
  std::vector<RigidMotion> poses;
  for (const Eigen::Matrix3d& turn : icosahedralRotations())
    poses.push_back({turn, target.centre() - turn * centre});
  return poses;
}

std::vector<StartPose> startPoses(const FittingModel& model, const FittingTarget& target, int keep,
                                  ThreadPool& pool) {
  const Samples samples = someOf(target);
  const SurfaceLocator mean(model.mean(), model.faces());
  const Points normals = faceNormals(model.mean(), model.faces());
  const Vector3 centre = model.mean().colwise().mean().transpose(),
                from = samples.points.colwise().mean().transpose();
  const std::vector<Eigen::Matrix3d> turns = icosahedralRotations();
  std::vector<StartPose> found = pool.makeEach(static_cast<int>(turns.size()), [&](int i) {
    const Eigen::Matrix3d& turn = turns[static_cast<size_t>(i)];
    return fitFrom(samples, model, mean, normals, {turn, centre - turn * from});
  });
  const StartPose asItLies = found.front();
  std::stable_sort(found.begin(), found.end(),
                   [](const StartPose& a, const StartPose& b) { return a.misfit < b.misfit; });
  std::vector<StartPose> best{asItLies};
  for (const StartPose& pose : found) {
    if (static_cast<int>(best.size()) == keep) break;
    const bool isNew = std::all_of(best.begin(), best.end(), [&](const StartPose& other) {
      return (other.motion.rotation - pose.motion.rotation).norm() > distinct;
    });
    if (isNew) best.push_back(pose);
  }
  return best;
}

}  // namespace sphere_propagation
