// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/registration/shape_alignment.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "vcg_ext/base/dense_cholesky.h"
#include "vcg_ext/registration/pose_starts.h"

namespace sphere_propagation {
namespace {

constexpr Eigen::Index samplesToChooseBy = 50;
constexpr int alignmentIterations = 10, anywhereIterations = 30;
constexpr size_t startsToRefine = 6;
constexpr double equallyGood = 1.05;
constexpr int planeIterations = 20;
constexpr Eigen::Index fewPlanes = 200, planes = 1000;  // first by few points, then by more
constexpr double nearlyThere = 1e-3, there = 1e-6;      // steps, in R
constexpr double planeAgreement = 0.5;                  // of normals

RigidMotion refined(const RigidMotion& start, const Points& points, const VertexLocator& vertices,
                    int iterations) {
  return alignRigidly(start.applyTo(points), vertices, iterations).motion * start;
}

/// Gauss-Newton on the distances of points from the planes at their closest points, as seen from
/// the centre. All lengths are counted in R, so that ridge and stop mean the same in any unit.
RigidMotion refinedByPlanes(const RigidMotion& start, const PreparedSurface& from,
                            const PreparedSurface& to, Eigen::Index count, double enough) {
  const Points& points = from.surface().vertices();
  const Eigen::Index step = std::max<Eigen::Index>(1, points.rows() / count);
  std::vector<int> nearby(static_cast<size_t>(points.rows()), -1);
  RigidMotion motion = start;
  for (int iteration = 0; iteration < planeIterations; ++iteration) {
    Eigen::Matrix<double, 6, 6> matrix = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> vector = Eigen::Matrix<double, 6, 1>::Zero();
    for (Eigen::Index i = 0; i < points.rows(); i += step) {
      const Vector3 x = motion.rotation * points.row(i).transpose() + motion.translation;
      const Vector3 direction = motion.rotation * from.normals().row(i).transpose();
      int& near = nearby[static_cast<size_t>(i)];
      const SurfacePoint closest = to.locator().closest(x, direction, planeAgreement, near);
      near = closest.face;
      if (closest.face < 0) continue;
      const Vector3 n = closest.interpolate(to.surface().faces(), to.normals()).normalized();
      const Vector3 p = closest.interpolate(to.surface().faces(), to.surface().vertices());
      const double scale = closest.distance / (0.1 * to.radius());
      const double weight = 1 / (1 + scale * scale);
      Eigen::Matrix<double, 6, 1> row;
      row << ((x - to.centre()) / to.radius()).cross(n), n;
      matrix += weight * row * row.transpose();
      vector += weight * row * n.dot(p - x) / to.radius();
    }
    matrix.diagonal().array() += 1e-6 * matrix.trace() / 6;  // round shapes turn freely: stay
    const Eigen::Matrix<double, 6, 1> step6 = solveSymmetric(matrix, vector);
    const Vector3 turn = step6.head<3>();
    const double angle = turn.norm();
    if (!step6.allFinite()) break;
    const Eigen::Matrix3d rotation = angle > 0
                                         ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix()
                                         : Eigen::Matrix3d::Identity();
    motion = {rotation * motion.rotation, rotation * (motion.translation - to.centre()) +
                                              to.centre() + to.radius() * step6.tail<3>()};
    if (step6.norm() < enough) break;
  }
  return motion;
}

}  // namespace

RigidMotion motionByAxes(const PreparedSurface& from, const PreparedSurface& to) {
  // The first of the samples are themselves spread, and enough to choose by.
  const Points few = from.samples().topRows(std::min(samplesToChooseBy, from.samples().rows()));
  RigidMotion start = poseAsTurned(from, to);
  double least = misfit(few, start, to.vertexLocator());
  for (const RigidMotion& motion : posesByAxes(from, to)) {
    const double sum = misfit(few, motion, to.vertexLocator());
    if (sum >= least) continue;
    least = sum;
    start = motion;
  }
  return refined(start, from.samples(), to.vertexLocator(), alignmentIterations);
}

RigidMotion motionFromAnywhere(const PreparedSurface& from, const PreparedSurface& to) {
  struct Candidate {
    RigidMotion motion;
    double misfit;
  };
  std::vector<Candidate> starts;
  for (const RigidMotion& motion : posesFromAnywhere(from, to))
    starts.push_back({motion, misfit(from.samples(), motion, to.vertexLocator())});
  std::stable_sort(starts.begin() + 1, starts.end(),
                   [](const Candidate& a, const Candidate& b) { return a.misfit < b.misfit; });
  starts.resize(std::min(starts.size(), startsToRefine));  // the first is how they are turned
  std::vector<double> distances;
  for (Candidate& start : starts) {
    start.motion = refined(start.motion, from.samples(), to.vertexLocator(), anywhereIterations);
    distances.push_back(shapeDistance(from, to, start.motion));
  }
  // Shapes that are nearly symmetric fit in several poses: of equally good ones the least turn.
  const double least = *std::min_element(distances.begin(), distances.end());
  RigidMotion best;
  double minAngle = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < starts.size(); ++i) {
    const double angle = Eigen::AngleAxisd(starts[i].motion.rotation).angle();
    if (distances[i] > equallyGood * least + 1e-9 * from.radius() || angle >= minAngle) continue;
    minAngle = angle;
    best = starts[i].motion;
  }
  const RigidMotion exact = refinedByPlanes(refinedByPlanes(best, from, to, fewPlanes, nearlyThere),
                                            from, to, planes, there);
  return shapeDistance(from, to, exact) <= equallyGood * least ? exact : best;
}

double shapeDistance(const PreparedSurface& from, const PreparedSurface& to,
                     const RigidMotion& motion) {
  const auto rootMeanSquare = [](const Points& points, const SurfaceLocator& surface) {
    double sum = 0;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const double distance = surface.closest(points.row(i).transpose()).distance;
      sum += distance * distance;
    }
    return std::sqrt(sum / static_cast<double>(points.rows()));
  };
  return (rootMeanSquare(motion.applyTo(from.samples()), to.locator()) +
          rootMeanSquare(motion.inverse().applyTo(to.samples()), from.locator())) /
         2;
}

double minShapeDistance(const PreparedSurface& a, const PreparedSurface& b) {
  const double radius = std::max(a.radius(), b.radius());
  return std::fabs(a.volume() - b.volume()) / (4 * pi * radius * radius);
}

}  // namespace sphere_propagation
