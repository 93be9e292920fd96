// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/area/area_restoration.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/core/test_meshes.h"
#include "vcg_ext/area/area_preserving_map.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/base/rotation.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/sphere/certificate.h"
#include "vcg_ext/sphere/map_measures.h"

namespace sphere_propagation {
namespace {

/// An ellipsoid on the sphere that it was made from: valid, far from area-preserving.
struct Example {
  test::Mesh mesh = test::noisyEllipsoid(1);
  ClosedSurface surface{mesh.vertices, mesh.faces};
  MappedSurface map{surface, test::icosphereMesh(8).vertices};
  double sd(const MappedSurface& of) const {
    return measureMap(surface, of.positions()).areaRatioSd;
  }
};

TEST(AreaRestoration, NothingAtZero) {
  const Example e;
  EXPECT_EQ(restoreArea(e.map, 0).positions(), e.map.positions());
}

TEST(AreaRestoration, PreservesAreasAtOne) {
  const Example e;
  const double scratch = e.sd(makeAreaPreserving(e.map).map);
  EXPECT_GT(e.sd(e.map), 0.15);
  EXPECT_LT(e.sd(restoreArea(e.map, 1)), 2 * scratch);
}

TEST(AreaRestoration, GoesFurtherTheMoreIsAskedFor) {
  const Example e;
  double before = e.sd(e.map);
  double moved = 0;
  for (double amount : {0.05, 0.25, 0.5, 0.75, 1.0}) {
    const MappedSurface restored = restoreArea(e.map, amount);
    EXPECT_TRUE(certify(e.surface.faces(), restored.positions()).valid());
    const double now = e.sd(restored), distance = (restored.positions() - e.map.positions()).norm();
    EXPECT_LT(now, before) << amount;
    EXPECT_GT(distance, moved) << amount;
    before = now;
    moved = distance;
  }
}

TEST(AreaRestoration, ALittleMovesLittle) {
  const Example e;
  const MappedSurface restored = restoreArea(e.map, 1e-4);
  EXPECT_LT((restored.positions() - e.map.positions()).rowwise().norm().maxCoeff(), 2e-3);
}

TEST(AreaRestoration, ReachesTheAreasBetween) {
  const Example e;
  const Eigen::ArrayXd before = areaRatios(e.surface, e.map.positions()).array();
  const Eigen::ArrayXd after = areaRatios(e.surface, restoreArea(e.map, 0.5).positions()).array();
  // s = sqrt(s0 a), so the ratio s / a is the root of what it was, but for one factor.
  const Eigen::ArrayXd quotient = after / before.sqrt();
  const double mean = quotient.mean();
  EXPECT_LT(((quotient / mean - 1).abs()).mean(), 0.01);
}

TEST(AreaRestoration, LeavesAnAreaPreservingMapAlone) {
  const Example e;
  const MappedSurface preserving = restoreArea(e.map, 1);
  const MappedSurface again = restoreArea(preserving, 1);
  EXPECT_LT((again.positions() - preserving.positions()).rowwise().norm().mean(), 0.01);
  EXPECT_LT(e.sd(again), e.sd(preserving) + 1e-4);
}

TEST(AreaRestoration, KeepsTheRotation) {
  const Example e;
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(e.surface.vertexCount());
  const Eigen::VectorXd areas = faceAreas(e.mesh.vertices, e.mesh.faces);
  for (int f = 0; f < e.surface.faceCount(); ++f)
    for (int k = 0; k < 3; ++k) weights[e.mesh.faces(f, k)] += areas[f];
  for (double amount : {0.3, 1.0}) {
    const Points restored = restoreArea(e.map, amount).positions();
    const Eigen::Matrix3d rotation =
        bestRotation(e.map.positions().transpose() * weights.asDiagonal() * restored);
    EXPECT_LT((rotation - Eigen::Matrix3d::Identity()).norm(), 1e-9);
  }
}

TEST(AreaRestoration, TurnsWithTheMap) {
  const Example e;
  const Eigen::Matrix3d rotation = test::randomRotation(3);
  const MappedSurface turned(e.surface, e.map.positions() * rotation.transpose());
  const Points a = restoreArea(e.map, 0.7).positions() * rotation.transpose();
  const Points b = restoreArea(turned, 0.7).positions();
  EXPECT_LT((a - b).rowwise().norm().maxCoeff(), 1e-5);
}

TEST(AreaRestoration, KeepsFacesOfAllSizesValid) {
  for (double least : {1e-2, 1e-4}) {
    const test::Mesh mesh = test::rings(least);
    test::Mesh stretched = mesh;
    stretched.vertices *= Vector3(3, 2, 1).asDiagonal();
    const ClosedSurface surface(stretched.vertices, stretched.faces);
    const MappedSurface restored = restoreArea(MappedSurface(surface, mesh.vertices), 1);
    EXPECT_TRUE(certify(surface.faces(), restored.positions()).valid());
  }
  const test::Mesh mesh = test::withZeroAreaFace();
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  test::Mesh round = mesh;
  round.vertices(6, 2) = 0.2;  // off the great circle of its edge
  round.vertices.rowwise().normalize();
  const MappedSurface restored = restoreArea(MappedSurface(surface, round.vertices), 1);
  EXPECT_TRUE(certify(surface.faces(), restored.positions()).valid());
}

TEST(AreaRestoration, TellsItsProgress) {
  const Example e;
  std::vector<double> told;
  restoreArea(e.map, 0.5, [&](double fraction) {
    if (!told.empty()) {
      EXPECT_GE(fraction, told.back());
    }
    told.push_back(fraction);
  });
  EXPECT_EQ(told.back(), 1);
}

TEST(AreaRestoration, RefusesWhatIsOutOfRange) {
  const Example e;
  for (double amount : {-0.01, 1.01, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(restoreArea(e.map, amount), ParameterError);
}

/// A round body on a map that gives its south little of the sphere: by a Moebius transformation,
/// areas go from 1 / 16 to 16 times their share.
MappedSurface squeezedMap() {
  const test::Mesh sphere = test::icosphereMesh(12);
  Points positions = sphere.vertices;
  for (auto u : positions.rowwise()) {
    const double stretch = 4 * std::sqrt((1 - u[2]) / std::max(1 + u[2], 1e-12)),
                 z = (1 - stretch * stretch) / (1 + stretch * stretch);
    const double round = std::hypot(u[0], u[1]);
    if (round > 0) u.head<2>() *= std::sqrt(1 - z * z) / round;
    u[2] = z;
    u.normalize();
  }
  return {ClosedSurface(sphere.vertices, sphere.faces), positions};
}

TEST(AreaBounds, OpenWhatIsSqueezedAndNoMore) {
  const MappedSurface map = squeezedMap();
  const double before = squeezedShare(map, 3);
  EXPECT_GT(before, 0.2);
  const MappedSurface opened = boundAreas(map, 3);
  EXPECT_TRUE(certify(opened.faces(), opened.positions()).valid());
  EXPECT_LT(squeezedShare(opened, 4), 0.02);
  // Not all areas were made alike: much still has less than two thirds of its share.
  EXPECT_GT(squeezedShare(opened, 1.5), 0.2);
  EXPECT_LT(squeezedShare(boundAreas(map, 1), 1.5), 0.02);
}

TEST(AreaBounds, LeaveMapsWithinThemBitForBit) {
  const MappedSurface map = squeezedMap();
  EXPECT_EQ(boundAreas(map, 40).positions(), map.positions());
  EXPECT_NE(boundAreas(map, 8).positions(), map.positions());
}

TEST(AreaBounds, AreFoundFromTheShareThatMayBeSqueezed) {
  const MappedSurface map = squeezedMap();
  double last = std::numeric_limits<double>::infinity();
  for (const double share : {0.0, 0.01, 0.1, 0.3}) {
    const double bound = boundOfSqueezing(map, share);
    EXPECT_LT(bound, last);
    EXPECT_LE(squeezedShare(map, bound * (1 + 1e-9)), share);
    EXPECT_GT(squeezedShare(map, bound * (1 - 1e-9)), share);
    last = bound;
  }
  EXPECT_EQ(boundOfSqueezing(map, 1), 1);
}

TEST(AreaBounds, RefuseWhatIsNone) {
  const MappedSurface map = squeezedMap();
  for (double bound : {0.99, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(boundAreas(map, bound), ParameterError);
  EXPECT_THROW(squeezedShare(map, 0), ParameterError);
}

TEST(BestRotation, IsProperAndFindsTheTurn) {
  const Points points = test::noisyEllipsoid(2).vertices;
  const Eigen::Matrix3d rotation = test::randomRotation(8);
  const Points turned = points * rotation.transpose();
  EXPECT_LT((bestRotation(turned.transpose() * points) - rotation).norm(), 1e-12);
  Points mirrored = points;
  mirrored.col(0) *= -1;
  EXPECT_NEAR(bestRotation(mirrored.transpose() * points).determinant(), 1, 1e-12);
}

}  // namespace
}  // namespace sphere_propagation
