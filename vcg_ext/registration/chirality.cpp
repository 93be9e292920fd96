// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/registration/chirality.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "vcg_ext/base/dense_cholesky.h"
#include "vcg_ext/registration/pose_starts.h"

namespace sphere_propagation {
namespace {

constexpr int roughIterations = 10, closestPointIterations = 15, affineIterations = 6;
constexpr size_t roughStarts = 4, startsToFit = 2;
constexpr double planesAgree = 0.5;  // dot product of normals
constexpr double strainRidge = 0.02, maxStrain = 0.5;

struct Affine {
  Eigen::Matrix3d linear;
  Vector3 translation;
  Vector3 operator()(const Vector3& x) const { return linear * x + translation; }
};

Isometry byClosestPoints(const Isometry& start, const PreparedSurface& from,
                         const PreparedSurface& to, int iterations) {
  return alignRigidly(start.applyTo(from.samples()), to.vertexLocator(), iterations).motion * start;
}

/// Gauss-Newton on the distances from planes, as seen from the centre and counted in R.
Affine affinely(const Isometry& start, const PreparedSurface& from, const PreparedSurface& to) {
  const Points& samples = from.samples();
  const double radius = to.radius();
  std::vector<int> near(static_cast<size_t>(samples.rows()), -1);
  Affine affine{start.rotation, start.translation}, best = affine;
  double least = HUGE_VAL;
  for (int iteration = 0; iteration <= affineIterations; ++iteration) {
    using Matrix12 = Eigen::Matrix<double, 12, 12>;
    using Vector12 = Eigen::Matrix<double, 12, 1>;
    Matrix12 matrix = Matrix12::Zero();
    Vector12 vector = Vector12::Zero();
    const Eigen::Matrix3d ofNormals = affine.linear.inverse().transpose();
    double weights = 0, sum = 0;
    for (Eigen::Index i = 0; i < samples.rows(); ++i) {
      const Vector3 x = affine(samples.row(i).transpose());
      const Vector3 direction = (ofNormals * from.sampleNormals().row(i).transpose()).normalized();
      int& face = near[static_cast<size_t>(i)];
      const SurfacePoint closest = to.locator().closest(x, direction, planesAgree, face);
      face = closest.face;
      if (face < 0) continue;
      const Vector3 n = closest.interpolate(to.surface().faces(), to.normals()).normalized();
      const Vector3 p = closest.interpolate(to.surface().faces(), to.surface().vertices());
      const double scale = closest.distance / (0.1 * radius), weight = 1 / (1 + scale * scale);
      const Vector3 y = (x - to.centre()) / radius;
      Vector12 row;
      row << n[0] * y, n[1] * y, n[2] * y, n;
      matrix += weight * row * row.transpose();
      vector += weight * row * n.dot(p - x) / radius;
      weights += weight;
      sum += weight * scale * scale;
    }
    if (!(weights > 0)) break;
    const double misfit = sum / weights;
    if (misfit < least) {
      least = misfit;
      best = affine;
    }
    matrix.diagonal().head<9>().array() += strainRidge * weights;
    matrix.diagonal().tail<3>().array() += 1e-6 * weights;
    const Vector12 step = solveSymmetric(matrix, vector);
    if (!step.allFinite() || step.norm() < 1e-3) break;
    Eigen::Matrix3d strain;
    strain << step.segment<3>(0).transpose(), step.segment<3>(3).transpose(),
        step.segment<3>(6).transpose();
    if (strain.norm() > maxStrain) break;
    const Eigen::Matrix3d factor = Eigen::Matrix3d::Identity() + strain;
    affine = {factor * affine.linear,
              factor * (affine.translation - to.centre()) + to.centre() + radius * step.tail<3>()};
  }
  return best;
}

/// In the radius of `to`.
double distanceAfter(const Affine& affine, const PreparedSurface& from, const PreparedSurface& to) {
  const auto rootMeanSquare = [](const Points& points, const Affine& moved,
                                 const SurfaceLocator& surface) {
    double sum = 0;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const double distance = surface.closest(moved(points.row(i).transpose())).distance;
      sum += distance * distance;
    }
    return std::sqrt(sum / static_cast<double>(points.rows()));
  };
  const Eigen::Matrix3d inverse = affine.linear.inverse();
  const Affine back{inverse, -inverse * affine.translation};
  return (rootMeanSquare(from.samples(), affine, to.locator()) / to.radius() +
          rootMeanSquare(to.samples(), back, from.locator()) / from.radius()) /
         2;
}

}  // namespace

Isometry reflection(const Vector3& normal, const Vector3& point) {
  Isometry isometry;
  isometry.rotation -= 2 * normal * normal.transpose();
  isometry.translation = 2 * normal.dot(point) * normal;
  return isometry;
}

Isometry reflection(int axis, double plane) {
  const Vector3 normal = Vector3::Unit(axis);
  return reflection(normal, plane * normal);
}

Isometry roughIsometry(const PreparedSurface& from, const PreparedSurface& to, bool mirroring) {
  const std::vector<Isometry> starts = posesFromAnywhere(from, to, mirroring);
  const Points few = from.samples().topRows(std::min<Eigen::Index>(50, from.samples().rows()));
  std::vector<std::pair<double, size_t>> order;
  for (size_t i = 0; i < starts.size(); ++i)
    order.emplace_back(misfit(few, starts[i], to.vertexLocator()), i);
  std::partial_sort(order.begin(), order.begin() + std::min(roughStarts, order.size()),
                    order.end());
  Isometry best;
  double least = HUGE_VAL;
  for (size_t k = 0; k < std::min(roughStarts, order.size()); ++k) {
    const Isometry there = byClosestPoints(starts[order[k].second], from, to, roughIterations);
    const double sum = misfit(from.samples(), there, to.vertexLocator());
    if (sum >= least) continue;
    least = sum;
    best = there;
  }
  return best;
}

Fit bestFit(const PreparedSurface& from, const PreparedSurface& to,
            const std::vector<Isometry>& starts) {
  const Points few = from.samples().topRows(std::min<Eigen::Index>(50, from.samples().rows()));
  std::vector<std::pair<double, size_t>> order;
  for (size_t i = 0; i < starts.size(); ++i)
    order.emplace_back(misfit(few, starts[i], to.vertexLocator()), i);
  std::sort(order.begin(), order.end());
  order.erase(
      std::unique(order.begin(), order.end(),  // in one frame several starts are the same
                  [](const auto& a, const auto& b) { return b.first <= (1 + 1e-9) * a.first; }),
      order.end());
  Fit best{HUGE_VAL, {}};
  for (size_t k = 0; k < std::min(startsToFit, order.size()); ++k) {
    const Isometry there =
        byClosestPoints(starts[order[k].second], from, to, closestPointIterations);
    const double distance = distanceAfter(affinely(there, from, to), from, to);
    if (distance < best.distance) best = {distance, there};
  }
  return best;
}

}  // namespace sphere_propagation
