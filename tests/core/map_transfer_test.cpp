// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/transfer/map_transfer.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>
#include <string>

#include "tests/core/test_meshes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation {
namespace {

using test::largestDistance;
using test::Mesh;

TEST(MapTransfer, ToTheSameSurfaceIsTheIdentity) {
  const Mesh mesh = test::noisyEllipsoid(1);
  const ClosedSurface surface = surfaceOf(mesh);
  const MappedSurface map(surface, test::icosphereMesh(8).vertices);
  const TransferredMap result = transferMap(map, mesh.vertices, surface);
  EXPECT_LT(largestDistance(result.map.positions(), map.positions()), 1e-12);
  EXPECT_EQ(result.repairedFaces, 0);
  EXPECT_LT(result.residual.p95, 1e-12);
}

TEST(MapTransfer, ToARigidlyMovedCopyIsTheIdentity) {
  const Mesh mesh = test::noisyEllipsoid(2);
  const ClosedSurface reference = surfaceOf(mesh);
  const MappedSurface map(reference, test::icosphereMesh(8).vertices);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Mesh moved =
        test::transformed(mesh, test::randomRotation(seed), 1, Vector3(50, -20, seed));
    const TransferredMap result = transferMap(map, moved.vertices, surfaceOf(moved));
    EXPECT_LT(largestDistance(result.map.positions(), map.positions()), 1e-12);
    EXPECT_EQ(result.repairedFaces, 0);
  }
}

TEST(MapTransfer, TipsKeepTheirPosition) {
  // The normal of an apex agrees with those of its faces by 0.05: other faces agree better, but
  // they are far away.
  Mesh mesh = test::bipyramid(8);
  const Points positions = mesh.vertices.rowwise().normalized();
  mesh.vertices.col(2) *= 20;
  const ClosedSurface surface = surfaceOf(mesh);
  const TransferredMap result =
      transferMap(MappedSurface(surface, positions), mesh.vertices, surface);
  EXPECT_LT(largestDistance(result.map.positions(), positions), 1e-12);
  EXPECT_EQ(result.repairedFaces, 0);
}

TEST(MapTransfer, ToFinerAndCoarserMeshesStaysCloseToTheTruth) {
  const int frequency = 8;
  const ClosedSurface reference = surfaceOf(test::ellipsoid(30, 20, 15, frequency));
  const MappedSurface map(reference, test::icosphereMesh(frequency).vertices);
  const double edge = 1.2 / frequency;  // of the reference, on the sphere
  for (int other : {3, 5, 11, 16, 30}) {
    const ClosedSurface target = surfaceOf(test::ellipsoid(30, 20, 15, other));
    const TransferredMap result = transferMap(map, reference.vertices(), target);
    EXPECT_TRUE(certify(target.faces(), result.map.positions()).valid());
    EXPECT_LT(largestDistance(result.map.positions(), test::icosphereMesh(other).vertices),
              edge * edge)
        << other;
    EXPECT_EQ(result.repairedFaces, 0) << other;
    EXPECT_EQ(static_cast<int>(result.distances.size()), target.vertexCount());
  }
}

TEST(MapTransfer, AFlippedPatchIsRepairedAndNothingElseMoves) {
  const Mesh mesh = test::ellipsoid(30, 20, 15, 8);
  const ClosedSurface reference = surfaceOf(mesh);
  const MappedSurface map(reference, test::icosphereMesh(8).vertices);
  Mesh folded = mesh;  // one vertex of the target lies beyond its neighbours
  const int v = 300, w = reference.ring(v)[0];
  folded.vertices.row(v) += 1.7 * (mesh.vertices.row(w) - mesh.vertices.row(v));
  const ClosedSurface target = surfaceOf(folded);
  const TransferredMap result = transferMap(map, mesh.vertices, target);
  EXPECT_GT(result.repairedFaces, 0);
  EXPECT_TRUE(certify(target.faces(), result.map.positions()).valid());
  int moved = 0;
  for (int u = 0; u < target.vertexCount(); ++u)
    moved += (result.map.position(u) - map.position(u)).norm() > 1e-12;
  EXPECT_LT(moved, 60);
}

TEST(MapTransfer, NormalsKeepTheSidesOfAThinSlabApart) {
  // A disc 0.6 thick, and the same 0.5 further up: what was below is now nearer to the other side.
  const Mesh mesh = test::ellipsoid(30, 30, 0.3, 8);
  const ClosedSurface reference = surfaceOf(mesh);
  const MappedSurface map(reference, test::icosphereMesh(8).vertices);
  const ClosedSurface target =
      surfaceOf(test::transformed(mesh, Eigen::Matrix3d::Identity(), 1, Vector3(0, 0, 0.5)));
  const TransferredMap result = transferMap(map, mesh.vertices, target);

  const SurfaceLocator locator(mesh.vertices, mesh.faces);
  int below = 0, misled = 0;
  for (int v = 0; v < target.vertexCount(); ++v) {
    const Vector3 truth = map.position(v);
    if (std::abs(truth.z()) < 0.3) continue;  // the rim
    EXPECT_GT(result.map.position(v).z() * truth.z(), 0) << v;
    EXPECT_LT((result.map.position(v) - truth).norm(), 0.05) << v;
    if (truth.z() > 0) continue;
    ++below;
    misled += locator.closest(target.vertex(v)).interpolate(mesh.faces, map.positions()).z() > 0;
  }
  EXPECT_GT(misled, below / 2) << "the sides are not close enough for this test to need normals";
}

TEST(MapTransfer, DistancesAreThoseOfTheVertices) {
  const ClosedSurface reference = surfaceOf(test::ellipsoid(10, 10, 10, 4)),
                      target = surfaceOf(test::ellipsoid(11, 11, 11, 4));
  const TransferredMap result = transferMap(
      MappedSurface(reference, test::icosphereMesh(4).vertices), reference.vertices(), target);
  ASSERT_EQ(static_cast<int>(result.distances.size()), target.vertexCount());
  for (double distance : result.distances) EXPECT_NEAR(distance, 1, 1e-12);
  EXPECT_NEAR(result.residual.mean, 1, 1e-12);
  EXPECT_NEAR(result.residual.p95, 1, 1e-12);
}

TEST(MapTransfer, TurnsWithTheReferencesMap) {
  const Mesh mesh = test::noisyEllipsoid(3);
  const ClosedSurface reference = surfaceOf(mesh);
  const ClosedSurface target = surfaceOf(test::transformed(
      test::noisyEllipsoid(4), test::randomRotation(1003) * test::randomRotation(1004).transpose(),
      1, Vector3::Zero()));
  const Points positions = test::icosphereMesh(8).vertices;
  const Eigen::Matrix3d rotation = test::randomRotation(5);
  const TransferredMap a = transferMap(MappedSurface(reference, positions), mesh.vertices, target);
  const TransferredMap b = transferMap(MappedSurface(reference, positions * rotation.transpose()),
                                       mesh.vertices, target);
  EXPECT_EQ(a.repairedFaces, b.repairedFaces);
  EXPECT_LT(largestDistance(b.map.positions(), a.map.positions() * rotation.transpose()), 1e-9);
}

TEST(MapTransfer, RefusesVerticesThatAreNotTheReferences) {
  const ClosedSurface reference = surfaceOf(test::icosahedron(), "phase 7"),
                      other = surfaceOf(test::octahedron());
  const MappedSurface map(reference, reference.vertices());
  EXPECT_THROW(transferMap(map, other.vertices(), other), ParameterError);
  Points moved = reference.vertices();
  moved(3, 1) = std::numeric_limits<double>::quiet_NaN();
  try {
    transferMap(map, moved, other);
    FAIL() << "no error";
  } catch (const ParameterError& error) {
    EXPECT_NE(std::string(error.what()).find("phase 7"), std::string::npos);
  }
}

}  // namespace
}  // namespace sphere_propagation
