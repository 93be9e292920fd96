// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/transfer/map_difference.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/core/test_meshes.h"
#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

TEST(MapDifference, IsNothingForEqualMaps) {
  const ClosedSurface surface = surfaceOf(test::noisyEllipsoid(1));
  const MappedSurface map(surface, test::icosphereMesh(8).vertices);
  const MapDifference difference = differenceOf(map, map);
  EXPECT_LT(difference.distance.p95, 1e-10);
  EXPECT_LT(difference.angle.p95, 1e-6);
}

TEST(MapDifference, ATurnOfASphereMovesItsLandmarksAlongIt) {
  constexpr double radius = 7, turn = 0.02;
  const test::Mesh sphere = test::icosphereMesh(20);
  const ClosedSurface surface =
      surfaceOf(test::transformed(sphere, Eigen::Matrix3d::Identity(), radius, Vector3(1, 2, 3)));
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(turn, Vector3(1, 2, 2) / 3).toRotationMatrix();
  const MappedSurface map(surface, sphere.vertices),
      turned(surface, sphere.vertices * rotation.transpose());
  const MapDifference difference = differenceOf(map, turned);
  // The mean of the sine of the distance from the axis is pi / 4.
  EXPECT_NEAR(difference.angle.mean, turn * 180 / pi * pi / 4, 0.01);
  EXPECT_NEAR(difference.distance.mean, radius * turn * pi / 4, 0.002);
  EXPECT_LT(difference.distance.p95, radius * turn);
  const MapDifference back = differenceOf(turned, map);
  EXPECT_NEAR(back.distance.mean, difference.distance.mean, 1e-4);
}

TEST(MapDifference, RefusesMapsOfOthers) {
  const ClosedSurface surface = surfaceOf(test::octahedron()),
                      other = surfaceOf(test::icosahedron());
  const MappedSurface map(surface, test::octahedron().vertices),
      foreign(other, test::icosahedron().vertices);
  EXPECT_THROW(differenceOf(map, foreign), ParameterError);
  EXPECT_THROW(differenceOf(foreign, map), ParameterError);
}

}  // namespace
}  // namespace sphere_propagation
