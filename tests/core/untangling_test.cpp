// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/repair/untangling.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "tests/core/limb_meshes.h"
#include "tests/core/sizes.h"
#include "tests/core/test_meshes.h"
#include "vcg_ext/root_map/harmonic_map.h"
#include "vcg_ext/sphere/certificate.h"
#include "vcg_ext/sphere/repair/relocation.h"

namespace sphere_propagation::test {
namespace {

/// Within `rings` edges of the centres.
std::set<int> neighbourhood(const ClosedSurface& surface, std::set<int> centres, int rings) {
  for (int ring = 0; ring < rings; ++ring) {
    const std::set<int> inner = centres;
    for (int v : inner)
      for (int w : surface.ring(v)) centres.insert(w);
  }
  return centres;
}

TEST(Relocation, MovesOnlyVerticesOfFlippedFaces) {
  const Mesh mesh = icosphereMesh(12);
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  Points positions = mesh.vertices;
  std::set<int> pushed;
  for (const int centre : {0, 40, 300, 500, 501, 1000, 1300}) {
    pushed.insert(centre);
    positions.row(centre) += 1.4 * (positions.row(surface.ring(centre)[0]) - positions.row(centre));
  }
  positions.rowwise().normalize();
  const int flipped = static_cast<int>(certify(mesh.faces, positions).flippedFaces);
  ASSERT_GT(flipped, 6);
  Points relocated = positions;
  EXPECT_EQ(relocateFlipped(mesh.faces, relocated), flipped);
  EXPECT_TRUE(certify(mesh.faces, relocated).valid());
  const std::set<int> near = neighbourhood(surface, pushed, 1);
  for (int v = 0; v < surface.vertexCount(); ++v) {
    if (near.count(v) > 0) continue;
    EXPECT_EQ(relocated.row(v), positions.row(v)) << v;
  }
  EXPECT_LT((relocated - positions).rowwise().norm().maxCoeff(), 0.25);
}

TEST(Relocation, LeavesAMapAndSaysWhereItCannotHelp) {
  const Mesh mesh = icosphereMesh(4);
  Points positions = mesh.vertices;
  EXPECT_EQ(relocateFlipped(mesh.faces, positions), 0);
  EXPECT_EQ(positions, mesh.vertices);
  positions *= -1;  // inside out
  EXPECT_EQ(relocateFlipped(mesh.faces, positions), -1);
}

TEST(Untangling, LeavesAMapAsItIs) {
  const Mesh mesh = icosphereMesh(6);
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  const Untangled result = untangle(surface, mesh.vertices);
  EXPECT_EQ(result.repairedFaces, 0);
  EXPECT_EQ(result.movedVertices, 0);
  EXPECT_LT((result.map.positions() - mesh.vertices).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(Untangling, BringsPositionsOfAnyLengthToTheSphere) {
  const Mesh mesh = icosphereMesh(3);
  Points positions = mesh.vertices;
  for (Eigen::Index v = 0; v < positions.rows(); ++v)
    positions.row(v) *= std::pow(10.0, v % 20 - 10);
  const Untangled result = untangle(ClosedSurface(mesh.vertices, mesh.faces), positions);
  EXPECT_EQ(result.repairedFaces, 0);
  EXPECT_LT((result.map.positions() - mesh.vertices).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(Untangling, MovesOnlyWhatLiesAroundFlippedFaces) {
  const Mesh mesh = icosphereMesh(12);
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  for (const int centre : {0, 500, 1000}) {
    // Pushed over the far side of its ring.
    Points positions = mesh.vertices;
    positions.row(centre) += 1.4 * (positions.row(surface.ring(centre)[0]) - positions.row(centre));
    positions.rowwise().normalize();
    const Certificate before = certify(mesh.faces, positions);
    ASSERT_GT(before.flippedFaces, 0);
    const Untangled result = untangle(surface, positions);
    EXPECT_EQ(result.repairedFaces, before.flippedFaces);
    const std::set<int> near = neighbourhood(surface, {centre}, 3);
    int moved = 0;
    for (int v = 0; v < surface.vertexCount(); ++v) {
      const bool same = (result.map.positions().row(v) - positions.row(v)).norm() < 1e-15;
      moved += !same;
      if (near.count(v) == 0) {
        EXPECT_TRUE(same) << "vertex " << v;
      }
    }
    EXPECT_EQ(result.movedVertices, moved);
    EXPECT_GT(moved, 2);
  }
}

TEST(Untangling, GrowsTheRingWhereOneIsNotEnough) {
  // A whole patch collapsed onto one point.
  const Mesh mesh = icosphereMesh(12);
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  Points positions = mesh.vertices;
  const std::set<int> patch = neighbourhood(surface, {700}, 4);
  for (int v : patch) positions.row(v) = mesh.vertices.row(700);
  const Untangled result = untangle(surface, positions);
  EXPECT_GT(result.repairedFaces, 80);
  const std::set<int> near = neighbourhood(surface, patch, 5);
  for (int v = 0; v < surface.vertexCount(); ++v)
    if (near.count(v) == 0) {
      EXPECT_LT((result.map.positions().row(v) - positions.row(v)).norm(), 1e-15);
    }
}

TEST(Untangling, TakesFewRoundsWhereLimbsAreLongAndTellsItsProgress) {
  const Mesh mesh = limbs(8, sizeFor(3, 2));
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  std::vector<double> reports;  // one a round
  EXPECT_THROW(untangle(surface, harmonicPositions(surface), std::numeric_limits<int>::max(),
                        [&](double share) { reports.push_back(share); }),
               MapError);
  EXPECT_GT(reports.size(), 3U);
  EXPECT_LT(reports.size(), 15U);
  EXPECT_TRUE(std::is_sorted(reports.begin(), reports.end()));
  EXPECT_GT(reports.back(), 0.5);
  EXPECT_LE(reports.back(), 1);
}

TEST(Untangling, GrowsNoFartherThanItMay) {
  const Mesh mesh = limbs(8, sizeFor(3, 2));
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  const Points positions = harmonicPositions(surface);  // no local repair helps
  for (const int rings : {0, 1, 2, 3, 4}) {
    int rounds = 0;
    EXPECT_THROW(untangle(surface, positions, rings, [&](double) { ++rounds; }), MapError);
    EXPECT_EQ(rounds, rings);
  }
}

TEST(Untangling, MendsScatteredFlips) {
  const Mesh mesh = icosphereMesh(12);
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  Random random(3);
  for (int trial = 0; trial < 5; ++trial) {
    Points positions = mesh.vertices;
    for (int i = 0; i < 40; ++i)
      positions.row(random.index(surface.vertexCount())) += 0.15 * random.direction().transpose();
    const Untangled result = untangle(surface, positions);
    EXPECT_GT(result.repairedFaces, 5);
    EXPECT_LT(result.movedVertices, surface.vertexCount() / 2);
  }
}

TEST(Untangling, FindsAPlaceForPositionsThatAreNoNumbers) {
  const Mesh mesh = icosphereMesh(8);
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  Points positions = mesh.vertices;
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                   infinity = std::numeric_limits<double>::infinity();
  positions.row(10).setConstant(nan);
  positions(200, 1) = nan;
  positions(300, 2) = -infinity;
  positions.row(400).setZero();
  for (int w : surface.ring(500)) positions.row(w).setConstant(nan);
  const Untangled result = untangle(surface, positions);  // a MappedSurface is valid by type
  EXPECT_GE(result.repairedFaces, 4 * 5);
  EXPECT_LT((result.map.position(10) - mesh.vertices.row(10).transpose()).norm(), 0.1);
}

TEST(Untangling, SaysHowFarFromAMapHopelessPositionsAre) {
  const Mesh mesh = icosphereMesh(4);
  const ClosedSurface surface(mesh.vertices, mesh.faces, "phase 7");
  Points nowhere = mesh.vertices;
  nowhere.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (const Points& positions : {Points(-mesh.vertices), nowhere}) {
    try {
      untangle(surface, positions);
      FAIL() << "accepted";
    } catch (const MapError& error) {
      EXPECT_EQ(error.fault(), Fault::NotRepairable);
      EXPECT_GT(error.finding().count, 0);
      EXPECT_GE(error.finding().first, 0);
      EXPECT_EQ(error.finding().name, "phase 7");
      EXPECT_EQ(error.finding().others, 320);  // flipped to begin with
      EXPECT_EQ(std::string(error.what()).find("They come from"), std::string::npos);
    }
  }
}

TEST(Untangling, RefusesAMapThatCoversTheSphereTwice) {
  // No face is flipped, but the degree is 2: longitude doubled between the poles.
  const Mesh mesh = bipyramid(8);
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  Points positions = mesh.vertices;
  for (int i = 0; i < 8; ++i)
    positions.row(2 + i) << std::cos(i * std::acos(0.0)), std::sin(i * std::acos(0.0)), 0;
  ASSERT_EQ(certify(mesh.faces, positions).flippedFaces, 0);
  EXPECT_THROW(untangle(surface, positions), MapError);
}

/// A cap that was turned as a whole: only its rim is folded. What lies farther inside and outside
/// is not given up for that.
TEST(Mending, LeavesWhatLiesFarFromFoldsWhereItIs) {
  const test::Mesh mesh = test::icosphereMesh(24);
  const Vector3 centre = Vector3(0.3, 0.2, 1).normalized();
  const Eigen::AngleAxisd turn(0.3, centre.cross(Vector3::UnitX()).normalized());
  Points positions = mesh.vertices;
  for (auto x : positions.rowwise())
    if (x.dot(centre.transpose()) > std::cos(0.4)) x = (turn * Vector3(x.transpose())).transpose();
  const Untangled mended = mend(ClosedSurface(mesh.vertices, mesh.faces, "ball"), positions);
  EXPECT_EQ(certify(mesh.faces, mended.map.positions()).flippedFaces, 0);
  EXPECT_LT(mended.movedVertices, 400);  // with patches of twelve rings 497
}

}  // namespace
}  // namespace sphere_propagation::test
