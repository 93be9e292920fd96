// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/repair/nearby_map.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "tests/core/test_meshes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/root_map/root_map.h"
#include "vcg_ext/sphere/certificate.h"
#include "vcg_ext/sphere/repair/untangling.h"

namespace sphere_propagation {
namespace {

TEST(NearbyMap, LeavesAValidMapAlone) {
  for (const test::Mesh& mesh :
       {test::noisyEllipsoid(3), test::cup(0.2, 24, 12), test::box(5), test::tetrahedron()}) {
    const ClosedSurface surface = surfaceOf(mesh);
    const Points positions = makeRootMap(surface).map.positions();
    const Points found = nearbyMap(surface, positions).positions();
    EXPECT_LT((found - positions).cwiseAbs().maxCoeff(), 1e-12) << surface.vertexCount();
  }
}

TEST(NearbyMap, UnfoldsWhatIsFoldedAndNothingElse) {
  const test::Mesh sphere = test::icosphereMesh(12);
  const ClosedSurface surface = surfaceOf(sphere);
  // The cap beyond z = 0.8 turned inside out: mirrored at its axis, its rim as it was.
  Points positions = sphere.vertices;
  for (auto x : positions.rowwise())
    if (x[2] > 0.8) x[0] = -x[0];
  ASSERT_FALSE(certify(surface.faces(), positions).valid());
  const Points found = nearbyMap(surface, positions).positions();  // valid by type
  int moved = 0;
  for (Eigen::Index v = 0; v < found.rows(); ++v)
    if ((found.row(v) - positions.row(v)).norm() > 1e-12) {
      ++moved;
      EXPECT_GT(sphere.vertices(v, 2), 0.4) << v;
    }
  EXPECT_GT(moved, 0);
}

TEST(NearbyMap, GivesUpPositionsThatLeaveNoRoom) {
  test::Random random(7);
  const test::Mesh sphere = test::icosphereMesh(12);
  const ClosedSurface surface = surfaceOf(sphere);
  for (const double apart : {1e-6, 1e-7, 1e-8}) {
    // Half of them lie on one spot, in no order.
    Points positions = sphere.vertices;
    for (auto x : positions.rowwise())
      if (x[2] > 0) x = (Vector3(0, 0, 1) + apart * random.direction()).normalized().transpose();
    EXPECT_NO_THROW(nearbyMap(surface, positions)) << apart;
  }
}

TEST(NearbyMap, MakesAMapOfAnything) {
  test::Random random(5);
  for (const test::Mesh& mesh : {test::noisyEllipsoid(1), test::tetrapod(12), test::octahedron()}) {
    const ClosedSurface surface = surfaceOf(mesh);
    Points positions(surface.vertexCount(), 3);
    for (auto x : positions.rowwise()) x = random.direction().transpose();
    EXPECT_NO_THROW(nearbyMap(surface, positions));
    positions.row(1).setZero();
    positions.row(2).setConstant(std::numeric_limits<double>::quiet_NaN());
    EXPECT_NO_THROW(nearbyMap(surface, positions));
    positions.setZero();
    EXPECT_NO_THROW(nearbyMap(surface, positions));
  }
}

TEST(NearbyMap, IsWhatMendingEndsWith) {
  // Everything mirrored: no local repair helps.
  const test::Mesh sphere = test::icosphereMesh(6);
  const ClosedSurface surface = surfaceOf(sphere);
  Points positions = sphere.vertices;
  positions.col(0) *= -1;
  EXPECT_THROW(untangle(surface, positions), MapError);
  const Untangled mended = mend(surface, positions);
  EXPECT_EQ(mended.repairedFaces, surface.faceCount());
  EXPECT_LT(
      (mended.map.positions() - nearbyMap(surface, positions).positions()).cwiseAbs().maxCoeff(),
      1e-9);
}

TEST(NearbyMap, MendingIsLocalWhereThatDoes) {
  const test::Mesh sphere = test::icosphereMesh(8);
  const ClosedSurface surface = surfaceOf(sphere);
  Points positions = sphere.vertices;
  positions.row(100).swap(positions.row(surface.ring(100)[0]));
  const Untangled mended = mend(surface, positions), untangled = untangle(surface, positions);
  EXPECT_LT((mended.map.positions() - untangled.map.positions()).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT(mended.movedVertices, 40);
}

TEST(NearbyMap, IsTheSameEveryTime) {
  test::Random random(8);
  const ClosedSurface surface = surfaceOf(test::noisyEllipsoid(2));
  Points positions(surface.vertexCount(), 3);
  for (auto x : positions.rowwise()) x = random.direction().transpose();
  EXPECT_EQ(nearbyMap(surface, positions).positions(), nearbyMap(surface, positions).positions());
}

}  // namespace
}  // namespace sphere_propagation
