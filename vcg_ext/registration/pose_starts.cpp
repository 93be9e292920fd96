// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/registration/pose_starts.h"

#include <Eigen/Geometry>
#include <cmath>

#include "vcg_ext/mesh/icosphere.h"

namespace sphere_propagation {
namespace {

/// The turn about the one centre that ends at the other.
RigidMotion about(const PreparedSurface& from, const PreparedSurface& to,
                  const Eigen::Matrix3d& rotation) {
  return {rotation, to.centre() - rotation * from.centre()};
}

}  // namespace

std::vector<Eigen::Matrix3d> icosahedralRotations() {
  const Points corners = icosphere(1).vertices;
  const double edge = (corners.row(0) - corners.row(icosphere(1).faces(0, 1))).norm();
  const auto frame = [&](Eigen::Index i, Eigen::Index j) {
    Eigen::Matrix3d f;
    f.col(0) = corners.row(i).transpose();
    f.col(1) =
        (corners.row(j).transpose() - corners.row(i).dot(corners.row(j)) * f.col(0)).normalized();
    f.col(2) = f.col(0).cross(f.col(1));
    return f;
  };
  std::vector<Eigen::Matrix3d> rotations;
  Eigen::Matrix3d first;
  for (Eigen::Index i = 0; i < corners.rows(); ++i)
    for (Eigen::Index j = 0; j < corners.rows(); ++j) {
      if (i == j || std::fabs((corners.row(i) - corners.row(j)).norm() - edge) > 1e-6) continue;
      if (rotations.empty()) first = frame(i, j);
      rotations.emplace_back(frame(i, j) * first.transpose());
    }
  return rotations;
}

RigidMotion poseAsTurned(const PreparedSurface& from, const PreparedSurface& to) {
  return about(from, to, Eigen::Matrix3d::Identity());
}

std::vector<RigidMotion> posesByAxes(const PreparedSurface& from, const PreparedSurface& to,
                                     bool mirroring) {
  const double side = mirroring ? -1 : 1;  // an even number of signs does not mirror
  std::vector<RigidMotion> poses;
  for (const Vector3& sign :
       {Vector3(1, 1, 1), Vector3(1, -1, -1), Vector3(-1, 1, -1), Vector3(-1, -1, 1)})
    poses.push_back(
        about(from, to, to.axes() * (side * sign).asDiagonal() * from.axes().transpose()));
  return poses;
}

std::vector<RigidMotion> posesFromAnywhere(const PreparedSurface& from, const PreparedSurface& to,
                                           bool mirroring) {
  std::vector<RigidMotion> poses;
  if (mirroring)
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::Matrix3d across = Eigen::Matrix3d::Identity();
      across(axis, axis) = -1;
      poses.push_back(about(from, to, across));
    }
  else
    poses.push_back(poseAsTurned(from, to));
  for (const RigidMotion& pose : posesByAxes(from, to, mirroring)) poses.push_back(pose);
  const std::vector<Eigen::Matrix3d> turns = icosahedralRotations();
  const Vector3 side(1, 1, mirroring ? -1 : 1);
  for (size_t i = 1; i < turns.size(); ++i)
    poses.push_back(
        about(from, to, to.axes() * turns[i] * side.asDiagonal() * from.axes().transpose()));
  return poses;
}

double misfit(const Points& points, const RigidMotion& motion, const VertexLocator& vertices) {
  const Points moved = motion.applyTo(points);
  const std::vector<int> nearest = vertices.nearest(moved);
  double sum = 0;
  for (size_t i = 0; i < nearest.size(); ++i)
    sum +=
        (moved.row(static_cast<Eigen::Index>(i)) - vertices.points().row(nearest[i])).squaredNorm();
  return sum;
}

}  // namespace sphere_propagation
