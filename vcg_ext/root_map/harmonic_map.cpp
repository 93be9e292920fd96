// SPDX-License-Identifier: GPL-3.0-only
// S. Haker et al., Conformal surface parameterization for texture mapping, 2000.

#include "vcg_ext/root_map/harmonic_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "vcg_ext/base/linear_solvers.h"
#include "vcg_ext/base/rotation.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/root_map/moebius_balancing.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation {
namespace {

using PlanePoints = Eigen::Matrix<double, Eigen::Dynamic, 2>;

constexpr double positiveWeight = 0.01;  // of an edge; between equilateral triangles it is 0.58
constexpr double maxCotangent = 100, smallCotangent = 1e-4;
constexpr double minAngle = 0.5;  // radians, of a face to be taken out
constexpr int punctures = 12;

/// Within the unit cube, so that neither tiny nor huge coordinates leave the range of numbers.
Points normalised(const Points& vertices) {
  const Eigen::RowVector3d middle =
      0.5 * vertices.colwise().minCoeff() + 0.5 * vertices.colwise().maxCoeff();
  const double extent = (vertices.rowwise() - middle).cwiseAbs().maxCoeff();
  return (vertices.rowwise() - middle) / extent;
}

/// The share of each vertex in the surface, #V.
Eigen::VectorXd vertexShares(const Points& vertices, const Triangles& faces) {
  const Eigen::VectorXd areas = vertexAreas(vertices, faces);
  return areas / areas.sum();
}

double weightedMedian(const Eigen::VectorXd& values, const Eigen::VectorXd& shares) {
  std::vector<int> order(static_cast<size_t>(values.size()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) { return values[a] < values[b]; });
  double sum = 0;
  for (int i : order)
    if ((sum += shares[i]) >= 0.5) return values[i];
  return values[order.back()];
}

/// Faces to take out, one after the other each as far as possible from those before.
class PunctureSequence {
 public:
  PunctureSequence(const Points& vertices, const Triangles& faces, const Eigen::VectorXd& shares)
      : centroids_(faces.rows(), 3), distance_(faces.rows()) {
    const Eigen::VectorXd shape = cornerAngles(vertices, faces).rowwise().minCoeff();
    const double least = std::min(minAngle, 0.9 * shape.maxCoeff());
    const Eigen::RowVector3d middle = shares.transpose() * vertices;
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
      centroids_.row(f) =
          (vertices.row(faces(f, 0)) + vertices.row(faces(f, 1)) + vertices.row(faces(f, 2))) / 3;
      // The first one is the closest to the middle: 1e3 is more than any distance in the unit cube.
      distance_[f] = shape[f] < least ? -1 : 1e3 - (centroids_.row(f) - middle).norm();
    }
  }

  /// -1 when there is none left.
  int next() {
    Eigen::Index face = 0;
    if (!(distance_.maxCoeff(&face) > 0)) return -1;
    for (Eigen::Index f = 0; f < distance_.size(); ++f)
      distance_[f] = std::min(distance_[f], (centroids_.row(f) - centroids_.row(face)).norm());
    return static_cast<int>(face);
  }

 private:
  Points centroids_;
  Eigen::VectorXd distance_;  // to the closest of the faces taken so far
};

/// Plane positions of the vertices with a face at infinity, up to scale and translation.
class PunctureSystem {
 public:
  PunctureSystem(const ClosedSurface& surface, const Points& vertices, double minWeight)
      : surface_(surface), vertices_(vertices) {
    // Known up to a constant, so the last vertex stays at the origin.
    const Eigen::Index n = surface.vertexCount() - 1;
    solver_.compute(cotangentLaplacian(surface, minWeight).topLeftCorner(n, n));
  }

  PlanePoints solve(int face) const {
    const int a = surface_.faces()(face, 0), b = surface_.faces()(face, 1),
              c = surface_.faces()(face, 2);
    const Vector3 ab = (vertices_.row(b) - vertices_.row(a)).transpose(),
                  ac = (vertices_.row(c) - vertices_.row(a)).transpose();
    // Haker et al., equation (10): E = A + theta (B - A) is the foot of the height through C.
    const double base = ab.norm(), theta = ac.dot(ab) / ab.squaredNorm(),
                 height = (ac - theta * ab).norm();
    const Eigen::Index n = surface_.vertexCount() - 1;
    PlanePoints dipole = PlanePoints::Zero(n + 1, 2);
    dipole.row(a) << -1 / base, (1 - theta) / height;
    dipole.row(b) << 1 / base, theta / height;
    dipole.row(c) << 0, -1 / height;
    PlanePoints z = PlanePoints::Zero(n + 1, 2);
    z.topRows(n) = solver_.solve(dipole.topRows(n));
    return z;
  }

 private:
  const ClosedSurface& surface_;
  const Points& vertices_;
  SparseCholesky solver_;
};

/// Stereographic projection, the plane's origin to the north pole; orientation is kept, seen from
/// outside. Before it, half of the area is brought into the unit circle: a good start for the
/// balancing, taken where clusters are still told apart.
Points projected(PlanePoints z, const Eigen::VectorXd& shares) {
  z.rowwise() -=
      Eigen::RowVector2d(weightedMedian(z.col(0), shares), weightedMedian(z.col(1), shares));
  const double radius = weightedMedian(z.rowwise().norm(), shares);
  if (radius > 0) z /= radius;
  Points positions(z.rows(), 3);
  for (Eigen::Index v = 0; v < z.rows(); ++v) {
    const double square = z.row(v).squaredNorm();
    positions.row(v) << 2 * z(v, 0), 2 * z(v, 1), 1 - square;
    positions.row(v) /= 1 + square;
  }
  return positions;
}

/// Turns the positions so that sum of shares |R x - y|^2 over rotations R is the least, y the
/// vertices about their centre.
Points turnedLikeShape(const Points& positions, const Points& vertices,
                       const Eigen::VectorXd& shares) {
  const Eigen::RowVector3d middle = shares.transpose() * vertices;
  const Eigen::Matrix3d covariance =
      (vertices.rowwise() - middle).transpose() * shares.asDiagonal() * positions;
  Points turned = positions * bestRotation(covariance).transpose();
  turned.rowwise().normalize();
  return turned;
}

}  // namespace

Eigen::SparseMatrix<double> cotangentLaplacian(const ClosedSurface& surface, double minWeight) {
  const Points vertices = normalised(surface.vertices());
  const int halfEdges = 3 * surface.faceCount();
  Eigen::VectorXd cotangents(halfEdges);  // of the angle opposite to each half-edge
  for (int f = 0; f < surface.faceCount(); ++f) {
    Vector3 dots;
    double area = 0;
    for (int k = 0; k < 3; ++k) {
      const Eigen::RowVector3d tip = vertices.row(surface.faces()(f, (k + 2) % 3));
      const Vector3 a = (vertices.row(surface.faces()(f, k)) - tip).transpose(),
                    b = (vertices.row(surface.faces()(f, (k + 1) % 3)) - tip).transpose();
      dots[k] = a.dot(b);
      area = std::max(area, a.cross(b).norm());
    }
    // One divisor for all three, so that the face's share of the matrix stays positive
    // semidefinite.
    const double divisor = std::max(area, dots.cwiseAbs().maxCoeff() / maxCotangent);
    for (int k = 0; k < 3; ++k)
      cotangents[3 * f + k] = (divisor > 0 ? dots[k] / divisor : 0) + smallCotangent;
  }
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(2 * static_cast<size_t>(halfEdges));
  for (int h = 0; h < halfEdges; ++h) {
    const int g = surface.twin(h);
    if (g < h) continue;
    const double weight = std::max((cotangents[h] + cotangents[g]) / 2, minWeight);
    const int v = surface.origin(h), w = surface.target(h);
    entries.emplace_back(v, v, weight);
    entries.emplace_back(w, w, weight);
    entries.emplace_back(v, w, -weight);
    entries.emplace_back(w, v, -weight);
  }
  Eigen::SparseMatrix<double> matrix(surface.vertexCount(), surface.vertexCount());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

Points harmonicPositions(const ClosedSurface& surface) {
  const Points vertices = normalised(surface.vertices());
  const Eigen::VectorXd shares = vertexShares(vertices, surface.faces());
  Points best;
  long fewest = std::numeric_limits<long>::max();
  for (const double minWeight : {-std::numeric_limits<double>::infinity(), positiveWeight}) {
    const PunctureSystem system(surface, vertices, minWeight);
    PunctureSequence sequence(vertices, surface.faces(), shares);
    for (int i = 0; i < punctures; ++i) {
      const int face = sequence.next();
      if (face < 0) break;
      Points positions = turnedLikeShape(
          balanceByMoebius(projected(system.solve(face), shares), shares), vertices, shares);
      const Certificate certificate = certify(surface.faces(), positions);
      if (certificate.valid()) return positions;
      // A wrong degree is worse than any number of flipped faces.
      const long flaws = certificate.flippedFaces + certificate.notOnSphere +
                         (std::fabs(certificate.degree - 1) < 1e-3 ? 0 : surface.faceCount());
      if (flaws < fewest) fewest = flaws, best = std::move(positions);
    }
  }
  return best;
}

}  // namespace sphere_propagation
