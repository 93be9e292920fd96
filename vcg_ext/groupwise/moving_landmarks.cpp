// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/groupwise/moving_landmarks.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/sphere/repair/relocation.h"
#include "vcg_ext/sphere/repair/untangling.h"
#include "vcg_ext/sphere/spherical_triangle.h"

namespace sphere_propagation {
namespace {

constexpr double shares[]{1, 0.75, 0.5, 0.25};  // of the flows that a map follows
constexpr double parts[]{1, 0.5, 0.25, 0.1};    // of a field that the grid follows

bool isOriented(const Points& positions, const Triangles& faces) {
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const auto at = [&](int k) { return Vector3(positions.row(faces(f, k)).transpose()); };
    const Vector3 a = at(0), b = at(1), c = at(2);
    if (!(a.dot((b - a).cross(c - a)) > 0)) return false;
  }
  return true;
}

}  // namespace

MovingLandmarks::MovingLandmarks(const MappedSurface& surface,
                                 std::shared_ptr<const Icosphere> sphere)
    : sphere_(std::move(sphere)),
      surface_(surface),
      reader_(surface),
      directions_(sphere_->vertices),
      landmarks_(reader_.read(directions_)) {}

Eigen::VectorXd MovingLandmarks::fieldFor(const SphereFields& fields, const Eigen::Matrix3d& turn,
                                          const Points& displacements,
                                          const Eigen::VectorXd& weights, double damping,
                                          const Pulls& pulls) {
  // A landmark moves in the plane of its face, so two coordinates say all.
  const Eigen::Index landmarks = directions_.rows(), count = landmarks + pulls.directions.rows();
  Points at(count, 3);
  at.topRows(landmarks) = directions_;
  at.bottomRows(count - landmarks) = pulls.directions;
  const SurfaceLandmarks pulled =
      count > landmarks ? reader_.read(pulls.directions) : SurfaceLandmarks{};
  Points functionals(2 * count, 3);
  Eigen::VectorXf target(2 * count);
  for (Eigen::Index j = 0; j < count; ++j) {
    const bool isLandmark = j < landmarks;
    const Eigen::Index i = isLandmark ? j : j - landmarks;
    const Eigen::Matrix3d derivative =
        turn * (isLandmark ? landmarks_ : pulled).derivatives[static_cast<size_t>(i)];
    const Vector3 displacement =
        (isLandmark ? displacements : pulls.displacements).row(i).transpose();
    Vector3 s, t;
    tangentFrame(at.row(j).transpose(), s, t);
    Vector3 first = derivative * s, second = derivative * t;
    if (second.squaredNorm() > first.squaredNorm()) first.swap(second);
    first.stableNormalize();
    second -= second.dot(first) * first;
    second.stableNormalize();
    const double root = std::sqrt((isLandmark ? weights : pulls.weights)[i]);
    functionals.row(2 * j) = root * first.transpose() * derivative;
    functionals.row(2 * j + 1) = root * second.transpose() * derivative;
    target[2 * j] = static_cast<float>(root * first.dot(displacement));
    target[2 * j + 1] = static_cast<float>(root * second.dot(displacement));
  }
  const RowsF rows = fields.rows(at, functionals);
  Eigen::MatrixXf system = sumOfOuterProducts(rows);
  const float strength =
      static_cast<float>(damping) * system.trace() / std::max(fields.gram().trace(), 1e-30F);
  system += strength * fields.gram();
  const Eigen::VectorXf right = rows.transpose() * target;
  const Eigen::VectorXf theta = system.llt().solve(right);
  if (!theta.allFinite()) return Eigen::VectorXd::Zero(fields.count());
  return theta.cast<double>();
}

void MovingLandmarks::move(std::shared_ptr<const SphereFields> fields, Eigen::VectorXd theta,
                           double longest) {
  const double fastest = fields->at(directions_, theta).rowwise().norm().maxCoeff();
  if (!(fastest > 0)) return;
  theta *= std::min(1.0, longest / fastest);
  for (const double part : parts) {
    Points there = fields->flow(directions_, part * theta);
    if (!isOriented(there, sphere_->faces)) continue;
    directions_ = std::move(there);
    landmarks_ = reader_.read(directions_);
    steps_.push_back({std::move(fields), part * theta});
    return;
  }
}

Points MovingLandmarks::followed(Points points) const {
  for (const Step& step : steps_) points = step.fields->flow(points, step.theta);
  return points;
}

Points MovingLandmarks::undone(Points points, double share) const {
  for (auto step = steps_.rbegin(); step != steps_.rend(); ++step)
    points = step->fields->flow(points, share * step->theta, -1);
  return points;
}

FollowedMap MovingLandmarks::map() const {
  if (!steps_.empty())
    for (const double share : shares) {
      Points positions = undone(surface_.positions(), share);
      Points relocated = positions;
      if (const int flipped = relocateFlipped(surface_.faces(), relocated); flipped >= 0)
        if (std::optional<MappedSurface> valid =
                MappedSurface::ifValid(surface_.surface(), std::move(relocated)))
          return {std::move(*valid), flipped, share};
      try {
        Untangled untangled = mend(surface_.surface(), std::move(positions));
        return {std::move(untangled.map), untangled.repairedFaces, share};
      } catch (const MapError&) {
      }
    }
  return {surface_, 0, steps_.empty() ? 1.0 : 0.0};
}

}  // namespace sphere_propagation
