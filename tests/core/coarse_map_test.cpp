// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/anchors/coarse_map.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <vector>

#include "tests/core/test_meshes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation {
namespace {

constexpr int few = 200;

MappedSurface ballOfTwist(double angle) {
  test::Mesh mesh = test::icosphereMesh(12);
  Points positions = mesh.vertices;
  for (Eigen::Index v = 0; v < positions.rows(); ++v)
    positions.row(v) =
        positions.row(v) * Eigen::AngleAxisd(angle * positions(v, 2), Vector3::UnitZ()).matrix();
  return MappedSurface(surfaceOf(mesh, "ball"), positions);
}

/// 1 for the corners of a face.
std::vector<char> cornersOf(const MappedSurface& map, int face) {
  std::vector<char> kept(static_cast<size_t>(map.vertexCount()), 0);
  for (int k = 0; k < 3; ++k) kept[static_cast<size_t>(map.faces()(face, k))] = 1;
  return kept;
}

void leaveAsItIs(CoarseMap::Stage& stage) {
  EXPECT_GT(stage.kept.size(), static_cast<size_t>(few));
  EXPECT_TRUE(certify(stage.rings.faces, stage.positions).valid());
}

TEST(CoarseMap, HasAsManyVerticesAsAreAskedForAndPointsOfKeptFacesWhereTheyWere) {
  const MappedSurface map = ballOfTwist(0.5);
  for (const int face : {0, 7, 1234}) {
    const CoarseMap coarse(map, cornersOf(map, face), few);
    const MappedSurface left = coarse.map();
    EXPECT_EQ(left.vertexCount(), few);
    SurfacePoint point;
    point.face = face;
    point.weights = Vector3(0.5, 0.3, 0.2);
    const SurfacePoint there = coarse.onCoarse(point);
    EXPECT_LT((there.interpolate(left.faces(), left.positions()) -
               point.interpolate(map.faces(), map.positions()))
                  .norm(),
              1e-15);
    EXPECT_LT((there.interpolate(left.faces(), left.surface().vertices()) -
               point.interpolate(map.faces(), map.surface().vertices()))
                  .norm(),
              1e-15);
  }
}

TEST(CoarseMap, BringsAllVerticesBackToWhereTheyWere) {
  const MappedSurface map = ballOfTwist(0.5);
  CoarseMap coarse(map, cornersOf(map, 7), few);
  const MappedSurface back = coarse.refined(coarse.map().positions(), 2, leaveAsItIs);
  EXPECT_LT((back.positions() - map.positions()).cwiseAbs().maxCoeff(), 0.01);  // an edge is 0.09
  EXPECT_LT((back.positions() - map.positions()).rowwise().norm().mean(), 1e-3);
}

TEST(CoarseMap, CarriesThemAlongWithThoseThatMove) {
  // Into a twist that takes the equator's edges to twice their length.
  const MappedSurface map = ballOfTwist(0), other = ballOfTwist(1.5);
  CoarseMap coarse(map, cornersOf(map, 7), few);
  Points moved = coarse.map().positions();
  for (Eigen::Index v = 0; v < moved.rows(); ++v)
    moved.row(v) = moved.row(v) * Eigen::AngleAxisd(1.5 * moved(v, 2), Vector3::UnitZ()).matrix();
  int stages = 0;
  const MappedSurface back = coarse.refined(moved, 2, [&](CoarseMap::Stage& stage) {
    ++stages;
    leaveAsItIs(stage);
  });
  EXPECT_EQ(stages, 1);
  EXPECT_LT((back.positions() - other.positions()).cwiseAbs().maxCoeff(), 0.09);
  EXPECT_LT((back.positions() - other.positions()).rowwise().norm().mean(), 0.03);
  const std::vector<char> kept = cornersOf(map, 7);
  for (Eigen::Index v = 0; v < moved.rows(); ++v)
    if (kept[static_cast<size_t>(v)] != 0) {
      EXPECT_LT((back.positions().row(v) - other.positions().row(v)).norm(), 1e-15);
    }
}

TEST(CoarseMap, TakesWhatAStageMakesOfIt) {
  const MappedSurface map = ballOfTwist(0);
  CoarseMap coarse(map, cornersOf(map, 7), few);
  const Eigen::Matrix3d turn = test::randomRotation(3);
  bool turned = false;
  const MappedSurface back =
      coarse.refined(coarse.map().positions(), 2, [&](CoarseMap::Stage& stage) {
        if (!turned) stage.positions = stage.positions * turn.transpose();
        turned = true;
      });
  EXPECT_LT((back.positions() - map.positions() * turn.transpose()).cwiseAbs().maxCoeff(), 0.02);
}

TEST(CoarseMap, KeepsWhatItIsToldTo) {
  const MappedSurface map = ballOfTwist(0);
  std::vector<char> all(static_cast<size_t>(map.vertexCount()), 1);
  EXPECT_EQ(CoarseMap(map, all, few).map().vertexCount(), map.vertexCount());
  all[100] = 0;
  EXPECT_EQ(CoarseMap(map, all, few).map().vertexCount(), map.vertexCount() - 1);
}

}  // namespace
}  // namespace sphere_propagation
