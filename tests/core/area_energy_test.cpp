// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/area/area_energy.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "tests/core/test_meshes.h"
#include "vcg_ext/sphere/spherical_triangle.h"

namespace sphere_propagation::test {
namespace {

using Corners = std::array<Vector3, 3>;
using Frames = std::array<std::array<Vector3, 2>, 3>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// A positively oriented face on the sphere, not too thin, its frames and a target of another shape
/// and size.
struct Sample {
  Corners p;
  Frames frame;
  FaceTarget target;

  explicit Sample(Random& random) {
    const double size = std::pow(10.0, random.uniform(-3, 0));
    do {
      const Vector3 centre = random.direction();
      for (Vector3& corner : p) corner = (centre + size * random.direction()).normalized();
    } while (angle() < 0.05 * size * size);
    for (int k = 0; k < 3; ++k) tangentFrame(p[k], frame[k][0], frame[k][1]);
    Points vertices(3, 3);
    for (int k = 0; k < 3; ++k) vertices.row(k) = random.direction().transpose();
    target = faceTargets(vertices, Triangles(Eigen::RowVector3i(0, 1, 2)))[0];
    target.area = angle() * random.uniform(0.2, 5);
    target.weight = random.uniform(0.5, 2);
  }

  double angle() const { return solidAngle(p[0], p[1], p[2]); }

  double energy(const AreaEnergyWeights& weights, const Vector6& t) const {
    Corners moved;
    for (int k = 0; k < 3; ++k)
      moved[k] = (p[k] + t[2 * k] * frame[k][0] + t[2 * k + 1] * frame[k][1]).normalized();
    return faceEnergy(target, weights, solidAngle(moved[0], moved[1], moved[2]), moved);
  }
};

Vector6 gradientOf(const FaceExpansion& e) {
  Vector6 gradient;
  for (int k = 0; k < 3; ++k) gradient.segment<2>(2 * k) = e.gradient(k);
  return gradient;
}

Matrix6 hessianOf(const FaceExpansion& e, const Frames& frame) {
  Matrix6 hessian;
  for (int k = 0; k < 3; ++k)
    for (int l = 0; l < 3; ++l) hessian.block<2, 2>(2 * k, 2 * l) = e.hessian(k, l, frame);
  return hessian;
}

/// The second derivatives of f at 0 by central differences.
template <class Function>
Matrix6 secondDifferences(const Function& f, double h) {
  Matrix6 result;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      const Vector6 a = h * Vector6::Unit(i), b = h * Vector6::Unit(j);
      result(i, j) = (f(a + b) - f(a - b) - f(b - a) + f(-a - b)) / (4 * h * h);
    }
  return result;
}

double totalEnergy(const Mesh& mesh, const Points& positions, const AreaEnergyWeights& weights) {
  const std::vector<FaceTarget> targets = faceTargets(mesh.vertices, mesh.faces);
  double sum = 0;
  for (int f = 0; f < mesh.faces.rows(); ++f) {
    Corners p;
    for (int k = 0; k < 3; ++k) p[k] = positions.row(mesh.faces(f, k)).transpose();
    sum += faceEnergy(targets[f], weights, solidAngle(p[0], p[1], p[2]), p);
  }
  return sum;
}

TEST(AreaEnergy, OfTheIdentityOfRegularSolidsByHand) {
  // ln 1 = 0; cotangents 1/sqrt 3, which the blend with the equilateral triangle leaves; D = 2 x
  // the flat area, so that w q = (4 pi / F) x flat area / (4 pi / F): the sum is the area of the
  // solid.
  const double tetrahedronEdge = std::sqrt(8.0 / 3), icosahedronEdge = 1 / std::sin(2 * pi / 5);
  const double perFace = std::sqrt(3.0) / 4;
  for (const double scale : {1e-3, 1.0, 40.0}) {
    const Points small = scale * tetrahedron().vertices, large = scale * icosahedron().vertices;
    EXPECT_NEAR(totalEnergy({small, tetrahedron().faces}, tetrahedron().vertices, {7, 1}),
                4 * perFace * tetrahedronEdge * tetrahedronEdge, 1e-6);
    EXPECT_NEAR(totalEnergy({large, icosahedron().faces}, icosahedron().vertices, {7, 0.5}),
                0.5 * 20 * perFace * icosahedronEdge * icosahedronEdge, 1e-6);
  }
}

TEST(AreaEnergy, IsMinimalAtTheIdentityOfRegularSolids) {
  Random random(1);
  for (const Mesh& mesh : {tetrahedron(), octahedron(), icosahedron()})
    for (const AreaEnergyWeights& weights : {AreaEnergyWeights{1, 0}, {1, 0.3}}) {
      const double least = totalEnergy(mesh, mesh.vertices, weights);
      for (int i = 0; i < 50; ++i) {
        Points moved = mesh.vertices;
        for (Eigen::Index v = 0; v < moved.rows(); ++v)
          moved.row(v) += 0.01 * random.direction().transpose();
        moved.rowwise().normalize();
        EXPECT_GT(totalEnergy(mesh, moved, weights), least);
      }
    }
}

TEST(AreaEnergy, IsInfiniteForFacesWithoutASolidAngle) {
  Random random(2);
  const Sample sample(random);
  for (const double s : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_EQ(faceEnergy(sample.target, {1, 0.1}, s, sample.p),
              std::numeric_limits<double>::infinity());
}

TEST(AreaEnergy, CountsTwiceTooLargeAsMuchAsHalf) {
  Random random(3);
  const Sample sample(random);
  const double a = sample.target.area;
  EXPECT_NEAR(faceEnergy(sample.target, {1, 0}, 2 * a, sample.p),
              faceEnergy(sample.target, {1, 0}, a / 2, sample.p), 1e-14);
  EXPECT_NEAR(faceEnergy(sample.target, {1, 0}, 2 * a, sample.p),
              sample.target.weight * std::log(2.0) * std::log(2.0), 1e-14);
}

TEST(AreaEnergy, ExpansionAgreesWithTheEnergy) {
  Random random(4);
  for (int i = 0; i < 100; ++i) {
    const Sample sample(random);
    const AreaEnergyWeights weights{random.uniform(), random.uniform()};
    const FaceExpansion e = expandFaceEnergy(sample.target, weights, sample.p, sample.frame);
    EXPECT_DOUBLE_EQ(e.energy, faceEnergy(sample.target, weights, sample.angle(), sample.p));
    EXPECT_DOUBLE_EQ(e.solidAngle, sample.angle());
  }
}

TEST(AreaEnergy, GradientIsThatOfCentralDifferences) {
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    const Sample sample(random);
    for (const AreaEnergyWeights& weights : {AreaEnergyWeights{1, 0}, {0, 1}, {1, 0.3}}) {
      const Vector6 gradient =
          gradientOf(expandFaceEnergy(sample.target, weights, sample.p, sample.frame));
      const double h = 1e-4 * std::sqrt(sample.angle());
      for (int j = 0; j < 6; ++j) {
        const Vector6 t = h * Vector6::Unit(j);
        const double difference =
            (sample.energy(weights, t) - sample.energy(weights, -t)) / (2 * h);
        EXPECT_NEAR(gradient[j], difference, 1e-4 * gradient.norm() + 1e-9) << "coordinate " << j;
      }
    }
  }
}

TEST(AreaEnergy, HessianIsSymmetricAndPositiveSemidefinite) {
  Random random(6);
  for (int i = 0; i < 500; ++i) {
    const Sample sample(random);
    const AreaEnergyWeights weights{random.uniform(), random.uniform()};
    const Matrix6 hessian =
        hessianOf(expandFaceEnergy(sample.target, weights, sample.p, sample.frame), sample.frame);
    const double scale = hessian.norm();
    EXPECT_LT((hessian - hessian.transpose()).norm(), 1e-14 * scale);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6>(hessian).eigenvalues()[0], -1e-12 * scale);
  }
}

TEST(AreaEnergy, HessianOfTheLogarithmIsExactWhereTheAreaIsRight) {
  Random random(7);
  for (int i = 0; i < 50; ++i) {
    Sample sample(random);
    sample.target.area = sample.angle();
    const AreaEnergyWeights weights{1, 0};
    const FaceExpansion e = expandFaceEnergy(sample.target, weights, sample.p, sample.frame);
    EXPECT_LT(gradientOf(e).norm(), 1e-12 * std::sqrt(hessianOf(e, sample.frame).norm()));
    const Matrix6 differences =
        secondDifferences([&](const Vector6& t) { return sample.energy(weights, t); },
                          1e-3 * std::sqrt(sample.angle()));
    EXPECT_LT((hessianOf(e, sample.frame) - differences).norm(), 1e-3 * differences.norm());
  }
}

TEST(AreaEnergy, HessianOfTheQuotientIsExactButForTheCurvatureOfArea) {
  Random random(8);
  for (int i = 0; i < 50; ++i) {
    const Sample sample(random);
    const FaceExpansion log = expandFaceEnergy({1, 1, {0, 0, 0}}, {1, 0}, sample.p, sample.frame);
    const double s = sample.angle();
    const Vector6 gradientOfAngle =
        gradientOf(log) * s / (2 * std::log(s));  // of ln^2 s: 2 ln s / s times it
    const auto linearised = [&](const Vector6& t) {
      Corners p = sample.p;
      for (int k = 0; k < 3; ++k)
        p[k] += t[2 * k] * sample.frame[k][0] + t[2 * k + 1] * sample.frame[k][1];
      return faceEnergy(sample.target, {0, 1}, s + gradientOfAngle.dot(t), p);
    };
    const Matrix6 hessian =
        hessianOf(expandFaceEnergy(sample.target, {0, 1}, sample.p, sample.frame), sample.frame);
    const Matrix6 differences = secondDifferences(linearised, 1e-3 * std::sqrt(s));
    EXPECT_LT((hessian - differences).norm(), 1e-3 * differences.norm());
  }
}

TEST(FaceTargets, ShareTheSphereByArea) {
  const Mesh mesh = noisyEllipsoid(1);
  const std::vector<FaceTarget> targets = faceTargets(mesh.vertices, mesh.faces),
                                larger = faceTargets(100 * mesh.vertices, mesh.faces);
  double sum = 0;
  for (const FaceTarget& target : targets) sum += target.area;
  EXPECT_NEAR(sum, 4 * pi, 1e-12);
  for (size_t f = 0; f < targets.size(); ++f) {
    const double mean = 4 * pi / static_cast<double>(targets.size());
    EXPECT_NEAR(targets[f].weight, std::sqrt(targets[f].area * mean), 1e-15);
    EXPECT_FLOAT_EQ(targets[f].shapeWeight, static_cast<float>(mean));
    EXPECT_NEAR(larger[f].area / targets[f].area, 1, 1e-12);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(larger[f].stiffness[k], targets[f].stiffness[k], 1e-5);
  }
}

TEST(FaceTargets, BlendCotangentsWithTheEquilateralTriangle) {
  Points vertices(3, 3);
  vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0;
  const Triangles face(Eigen::RowVector3i(0, 1, 2));
  const double share = 0.1 / std::sqrt(3.0);
  const ShapeTrust trust{0.1, 0.02};
  const FaceTarget right = faceTargets(vertices, face, trust)[0];
  EXPECT_NEAR(right.stiffness[0], share, 1e-7);
  EXPECT_NEAR(right.stiffness[1], 0.9 + share, 1e-7);
  EXPECT_NEAR(right.stiffness[2], 0.9 + share, 1e-7);
}

TEST(FaceTargets, FacesWithoutAreaGetAPlace) {
  Mesh mesh = octahedron();
  mesh.vertices.row(1) = mesh.vertices.row(2);  // two faces without area but with a length
  mesh.vertices.row(5) = mesh.vertices.row(2);  // and two that are a point or a line
  for (const FaceTarget& target : faceTargets(mesh.vertices, mesh.faces)) {
    EXPECT_GT(target.area, 1e-6);
    // Each pair sums to a positive number: the Dirichlet energy is positive for every shape.
    for (int k = 0; k < 3; ++k) {
      EXPECT_TRUE(std::isfinite(target.stiffness[k]));
      EXPECT_GT(target.stiffness[k] + target.stiffness[(k + 1) % 3], 0);
    }
  }
}

}  // namespace
}  // namespace sphere_propagation::test
