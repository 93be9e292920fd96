#include "vcg_ext/map/area_energy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "vcg_ext/map/spherical_triangle.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

constexpr double leastArea = 1e-5;  // of the mean face area
/// The mesh's cotangents are blended with an equilateral triangle's: slivers of the mesh need not be slivers on the
/// sphere.
constexpr double equilateralShare = 0.1;
constexpr double equilateralCotangent = 0.57735026918962576;
/// Least area of a triangle in its cotangents, in units of the sum of its squared edges.
constexpr double leastFlatness = 0.02;

/// Dirichlet energy of a face on the sphere.
double dirichlet(const FaceTarget& target, const std::array<Vector3, 3>& p) {
  return 0.5 * (target.stiffness[0] * (p[1] - p[2]).squaredNorm() + target.stiffness[1] * (p[2] - p[0]).squaredNorm() +
                target.stiffness[2] * (p[0] - p[1]).squaredNorm());
}

}  // namespace

std::vector<FaceTarget> faceTargets(const Points& vertices, const Triangles& faces) {
  Eigen::VectorXd areas = faceAreas(vertices, faces);
  areas = areas.cwiseMax(leastArea * areas.mean());
  areas *= 4 * pi / areas.sum();
  const double mean = areas.mean();
  std::vector<FaceTarget> targets(static_cast<size_t>(faces.rows()));
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    FaceTarget& target = targets[static_cast<size_t>(f)];
    target.area = areas[f];
    target.weight = std::sqrt(areas[f] * mean);
    std::array<Vector3, 3> p;
    for (int k = 0; k < 3; ++k) p[k] = vertices.row(faces(f, k)).transpose();
    std::array<double, 3> squared{};  // length of the edge opposite each corner
    for (int k = 0; k < 3; ++k) squared[k] = (p[(k + 1) % 3] - p[(k + 2) % 3]).squaredNorm();
    const double sum = squared[0] + squared[1] + squared[2];
    const double area = std::max(0.5 * (p[1] - p[0]).cross(p[2] - p[0]).stableNorm(), leastFlatness * sum);
    for (int k = 0; k < 3; ++k) {
      const double cotangent = area > 0 ? (sum - 2 * squared[k]) / (4 * area) : equilateralCotangent;
      target.stiffness[k] = (1 - equilateralShare) * cotangent + equilateralShare * equilateralCotangent;
    }
  }
  return targets;
}

double faceEnergy(const FaceTarget& target, const AreaEnergyWeights& weights, double s,
                  const std::array<Vector3, 3>& p) {
  if (!(s > 0)) return std::numeric_limits<double>::infinity();
  const double r = std::log(s / target.area);
  return target.weight * (weights.area * r * r + weights.shape * dirichlet(target, p) / (2 * s));
}

FaceExpansion expandFaceEnergy(const FaceTarget& target, const AreaEnergyWeights& weights,
                               const std::array<Vector3, 3>& p, const std::array<std::array<Vector3, 2>, 3>& frame) {
  FaceExpansion e;
  std::array<Tangent, 3> logArea;   // gradient of ln s
  std::array<Tangent, 3> quotient;  // gradient of D, divided by 2 s
  std::array<Vector3, 3> gradientOfArea;
  const double s = e.solidAngle = solidAngle(p, gradientOfArea);
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const Vector3 d = target.stiffness[j] * (p[k] - p[i]) + target.stiffness[i] * (p[k] - p[j]);
    logArea[k] = Tangent(gradientOfArea[k].dot(frame[k][0]), gradientOfArea[k].dot(frame[k][1])) / s;
    quotient[k] = Tangent(d.dot(frame[k][0]), d.dot(frame[k][1])) / (2 * s);
  }
  const double r = std::log(s / target.area), q = dirichlet(target, p) / (2 * s);
  const double wa = target.weight * weights.area, wq = target.weight * weights.shape;
  e.energy = wa * r * r + wq * q;
  for (int k = 0; k < 3; ++k) {
    e.gradient[k] = 2 * wa * r * logArea[k] + wq * (quotient[k] - q * logArea[k]);
    for (int l = 0; l < 3; ++l) {
      // D(x) / s: with K the stiffness, K/s - (Kx g^T + g (Kx)^T)/s^2 + 2 D g g^T / s^3, here all over 2.
      TangentBlock& block = e.hessian[k][l];
      block.noalias() = (2 * wa + 2 * wq * q) * logArea[k] * logArea[l].transpose();
      block -= wq * (quotient[k] * logArea[l].transpose() + logArea[k] * quotient[l].transpose());
      if (k == l) {
        block +=
            wq * (target.stiffness[(k + 1) % 3] + target.stiffness[(k + 2) % 3]) / (2 * s) * TangentBlock::Identity();
      } else {
        TangentBlock turn;
        for (int a = 0; a < 2; ++a)
          for (int b = 0; b < 2; ++b) turn(a, b) = frame[k][a].dot(frame[l][b]);
        block -= wq * target.stiffness[3 - k - l] / (2 * s) * turn;
      }
    }
  }
  return e;
}

}  // namespace sphere_propagation
