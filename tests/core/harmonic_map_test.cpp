// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/root_map/harmonic_map.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "tests/core/test_meshes.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/root_map/moebius_balancing.h"
#include "vcg_ext/sphere/map_measures.h"

namespace sphere_propagation {
namespace {

/// A third of the areas of the faces round each vertex.
Eigen::VectorXd vertexAreas(const ClosedSurface& surface) {
  const Eigen::VectorXd areas = faceAreas(surface.vertices(), surface.faces());
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(surface.vertexCount());
  for (int f = 0; f < surface.faceCount(); ++f)
    for (int k = 0; k < 3; ++k) sums[surface.faces()(f, k)] += areas[f] / 3;
  return sums;
}

double meanLength(const Points& positions, const Eigen::VectorXd& weights) {
  return (positions.transpose() * weights).norm() / weights.sum();
}

/// Largest distance between two maps.
double distance(const Points& a, const Points& b) { return (a - b).rowwise().norm().maxCoeff(); }

TEST(CotangentLaplacian, OfARegularOctahedronByHand) {
  const ClosedSurface surface = surfaceOf(test::octahedron());
  const Eigen::MatrixXd laplacian = cotangentLaplacian(surface);
  const double weight = 1 / std::sqrt(3.0) + 1e-4;  // two angles of 60 degrees
  for (int v = 0; v < 6; ++v) {
    EXPECT_NEAR(laplacian(v, v), 4 * weight, 1e-14);
    for (int w : surface.ring(v)) EXPECT_NEAR(laplacian(v, w), -weight, 1e-14);
  }
  EXPECT_EQ((laplacian.array() != 0).count(), 6 * 5);
}

TEST(CotangentLaplacian, KillsConstantsAndIsPositiveOnTheRest) {
  for (const test::Mesh& mesh :
       {test::noisyEllipsoid(1), test::withZeroAreaFace(), test::ellipsoid(1, 1, 1e-3, 3)}) {
    for (const double least : {-std::numeric_limits<double>::infinity(), 0.01}) {
      const Eigen::MatrixXd laplacian = cotangentLaplacian(surfaceOf(mesh), least);
      EXPECT_LT(laplacian.rowwise().sum().cwiseAbs().maxCoeff(), 1e-9);
      EXPECT_LT((laplacian - laplacian.transpose()).cwiseAbs().maxCoeff(), 1e-15);
      const Eigen::VectorXd values =
          Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(laplacian).eigenvalues();
      EXPECT_NEAR(values[0], 0, 1e-10);
      EXPECT_GT(values[1], 1e-6);
      if (least > 0) {
        EXPECT_LE((laplacian - Eigen::MatrixXd(laplacian.diagonal().asDiagonal())).maxCoeff(), 0);
      }
    }
  }
}

TEST(CotangentLaplacian, DoesNotDependOnScale) {
  const test::Mesh mesh = test::noisyEllipsoid(2);
  const Eigen::MatrixXd reference = cotangentLaplacian(surfaceOf(mesh));
  for (const double scale : {1e-150, 1e-3, 1e150}) {
    const Eigen::MatrixXd laplacian = cotangentLaplacian(
        surfaceOf(test::transformed(mesh, Eigen::Matrix3d::Identity(), scale, Vector3::Zero())));
    EXPECT_LT((laplacian - reference).cwiseAbs().maxCoeff(), 1e-8);
  }
}

TEST(MoebiusBalancing, CentresTheMeanAndKeepsCrossRatios) {
  test::Random random(4);
  Points points(200, 3);
  Eigen::VectorXd weights(200);
  for (int i = 0; i < 200; ++i) {
    points.row(i) = (random.direction() + Vector3(0.2, -0.3, 1.5))
                        .normalized()
                        .transpose();  // most of them near a pole
    weights[i] = random.uniform(0.1, 1);
  }
  EXPECT_GT(meanLength(points, weights), 0.5);
  const Points balanced = balanceByMoebius(points, weights);
  EXPECT_LT(meanLength(balanced, weights), 1e-11);
  EXPECT_LT((balanced.rowwise().norm().array() - 1).abs().maxCoeff(), 1e-14);
  // The modulus of the cross-ratio is what every Moebius transformation keeps.
  const auto crossRatio = [](const Points& p, int i) {
    const auto chord = [&](int a, int b) { return (p.row(i + a) - p.row(i + b)).norm(); };
    return chord(0, 1) * chord(2, 3) / (chord(0, 2) * chord(1, 3));
  };
  for (int i = 0; i + 3 < 200; ++i)
    EXPECT_NEAR(crossRatio(balanced, i) / crossRatio(points, i), 1, 1e-9)
        << "points " << i << " to " << i + 3;
}

TEST(MoebiusBalancing, LeavesWhatIsBalancedAndComesBackFromFarAway) {
  const test::Mesh mesh = test::transformed(test::icosphereMesh(4), test::randomRotation(1), 1,
                                            Vector3::Zero());  // no vertex at the pole
  const Eigen::VectorXd weights = Eigen::VectorXd::Ones(mesh.vertices.rows());
  EXPECT_LT(distance(balanceByMoebius(mesh.vertices, weights), mesh.vertices), 1e-12);
  // Towards the pole by the stereographic scale 300: half of the points within 0.4 degrees of it.
  Points far(mesh.vertices.rows(), 3);
  for (Eigen::Index i = 0; i < far.rows(); ++i) {
    const Vector3 x = mesh.vertices.row(i).transpose();
    const Vector2 z = Vector2(x[0], x[1]) / (1 + x[2]) / 300;
    far.row(i) << 2 * z[0], 2 * z[1], 1 - z.squaredNorm();
    far.row(i) /= 1 + z.squaredNorm();
  }
  ASSERT_TRUE(far.allFinite());
  EXPECT_GT(meanLength(far, weights), 0.95);
  // The transformation is known up to a rotation, which keeps all distances.
  const Points back = balanceByMoebius(far, weights);
  EXPECT_LT(((back * back.transpose()) - (mesh.vertices * mesh.vertices.transpose()))
                .cwiseAbs()
                .maxCoeff(),
            1e-9);
}

TEST(MoebiusBalancing, EndsWhereThereIsNoBalance) {
  Points points(3, 3);
  points << 1, 0, 0, 0, 1, 0, 0, 0, 1;
  EXPECT_TRUE(balanceByMoebius(points, Vector3(10, 1, 1)).allFinite());
  points.rowwise() = Eigen::RowVector3d(0, 0, 1);
  EXPECT_TRUE(balanceByMoebius(points, Vector3(1, 1, 1)).allFinite());
}

TEST(HarmonicMap, OfASphereIsTheSphereTurnedAlike) {
  // Conformally the sphere is itself; what is left is discretisation, mostly round the puncture,
  // and shrinks with it.
  double before = 0;
  for (const int frequency : {4, 8, 16}) {
    const test::Mesh mesh = test::icosphereMesh(frequency);
    const Eigen::Matrix3d rotation = test::randomRotation(7);
    const Points positions =
        harmonicPositions(surfaceOf(test::transformed(mesh, rotation, 12.5, {100, 200, 300})));
    const double error = (positions - mesh.vertices * rotation.transpose()).rowwise().norm().mean();
    EXPECT_LT(error, 0.25 / frequency);
    if (frequency > 4) {
      EXPECT_LT(error, 0.7 * before);
    }
    before = error;
  }
}

TEST(HarmonicMap, KeepsAngles) {
  // The faces of a stretched icosphere are obtuse in places: with clamped cotangents the error
  // would be 11 degrees.
  const ClosedSurface surface = surfaceOf(test::ellipsoid(30, 15, 10, 16));
  EXPECT_LT(measureMap(surface, harmonicPositions(surface)).angleErrorMean, 3.5);
}

TEST(HarmonicMap, IsBalancedOnTheSphereAndOrientationPreserving) {
  for (const test::Mesh& mesh :
       {test::tetrahedron(), test::octahedron(), test::bipyramid(9), test::ellipsoid(30, 20, 15),
        test::noisyEllipsoid(1), test::noisyEllipsoid(2), test::ellipsoid(30, 3, 2, 12)}) {
    const ClosedSurface surface = surfaceOf(mesh);
    const Points positions = harmonicPositions(surface);
    EXPECT_LT((positions.rowwise().norm().array() - 1).abs().maxCoeff(), 1e-14);
    EXPECT_LT(meanLength(positions, vertexAreas(surface)), 1e-6);
    const Certificate certificate = certify(surface.faces(), positions);
    EXPECT_TRUE(certificate.valid())
        << certificate.reason() << " (" << surface.vertexCount() << " vertices)";
  }
}

TEST(HarmonicMap, TurnsAndScalesWithTheShape) {
  const test::Mesh mesh = test::noisyEllipsoid(9);
  const Points reference = harmonicPositions(surfaceOf(mesh));
  for (unsigned seed = 0; seed < 3; ++seed)
    for (const double scale : {1e-100, 0.001, 1e100}) {
      const Eigen::Matrix3d rotation = test::randomRotation(seed);
      const Points positions = harmonicPositions(
          surfaceOf(test::transformed(mesh, rotation, scale, scale * Vector3(5, -1, 2))));
      EXPECT_LT(distance(positions, reference * rotation.transpose()), 1e-8);
    }
}

TEST(HarmonicMap, BearsFacesWithoutAreaAndExtremeShapes) {
  test::Mesh flattened = test::ellipsoid(30, 20, 1e-9);
  test::Mesh collapsed = test::noisyEllipsoid(4);
  for (int f = 0; f < 60; ++f)  // a tenth of the vertices moved onto a neighbour
    collapsed.vertices.row(collapsed.faces(21 * f, 0)) =
        collapsed.vertices.row(collapsed.faces(21 * f, 1));
  for (const test::Mesh& mesh :
       {test::withZeroAreaFace(), flattened, collapsed, test::ellipsoid(1000, 1, 1, 12)}) {
    const ClosedSurface surface = surfaceOf(mesh);
    const Points positions = harmonicPositions(surface);
    ASSERT_EQ(positions.rows(), surface.vertexCount());
    const Certificate certificate = certify(surface.faces(), positions);
    EXPECT_EQ(certificate.notOnSphere, 0);
    EXPECT_NEAR(certificate.degree, 1, 1e-6);
    EXPECT_LT(meanLength(positions, vertexAreas(surface)), 1e-6);
    EXPECT_LE(certificate.flippedFaces, surface.faceCount() / 50);
  }
}

}  // namespace
}  // namespace sphere_propagation
