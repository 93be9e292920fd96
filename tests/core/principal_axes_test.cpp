// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/registration/principal_axes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/core/test_meshes.h"

namespace sphere_propagation {
namespace {

using test::Mesh;

/// The ellipsoid (30, 20, 10), turned and moved. The icosphere's vertices do not reach the ends of
/// its axes, so its ranges are taken before it is turned.
struct TurnedEllipsoid {
  Eigen::Matrix3d rotation = test::randomRotation(7);
  Mesh straight = test::ellipsoid(30, 20, 10);
  Mesh turned = test::transformed(straight, rotation, 1, Vector3(5, -6, 7));
  Vector3 ranges =
      (straight.vertices.colwise().maxCoeff() - straight.vertices.colwise().minCoeff()).transpose();
};

TEST(PrincipalAxes, RecoverATurnedEllipsoid) {
  const TurnedEllipsoid e;
  const PrincipalAxes found = principalAxes(e.turned.vertices);
  EXPECT_LT((found.centroid - Vector3(5, -6, 7)).norm(), 1e-10);
  EXPECT_LT((found.ranges - e.ranges).norm(), 1e-9);
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(std::abs(found.axes.col(k).dot(e.rotation.col(k))), 1, 1e-12) << "axis " << k;
  EXPECT_NEAR(found.axes.determinant(), 1, 1e-12);
  const Vector3 variances =
      (e.straight.vertices.array().square().colwise().mean()).matrix().transpose();
  EXPECT_LT((found.variances - variances).norm(), 1e-9 * variances.norm());
}

TEST(PrincipalAxes, OfAFlatOrPointLikeCloud) {
  const PrincipalAxes point = principalAxes(Points::Constant(5, 3, 2.5));
  EXPECT_EQ(point.centroid, Vector3::Constant(2.5));
  EXPECT_EQ(point.ranges, Vector3::Zero());
  EXPECT_EQ(point.axes, Eigen::Matrix3d::Identity());
  Points line(3, 3);
  line << 0, 0, 0, 1, 1, 0, 2, 2, 0;
  const PrincipalAxes along = principalAxes(line);
  EXPECT_NEAR(along.ranges[0], std::sqrt(8.0), 1e-14);
  EXPECT_NEAR(along.ranges[1] + along.ranges[2], 0, 1e-14);
}

TEST(ScaledToExtents, ReachesTheReferencesRangesAlongItsOwnAxes) {
  const TurnedEllipsoid e;
  const Mesh reference =
      test::transformed(test::ellipsoid(12, 50, 25), test::randomRotation(8), 1, Vector3(1, 2, 3));
  const PrincipalAxes goal = principalAxes(reference.vertices);
  const Points scaled = scaledToExtents(e.turned.vertices, goal);
  EXPECT_LT((scaled.colwise().mean().transpose() - goal.centroid).norm(), 1e-10);
  // Nothing was turned: each of its own axes now has the range of the reference's axis of the same
  // rank.
  const Points along = (scaled.rowwise() - goal.centroid.transpose()) * e.rotation;
  const Vector3 ranges = (along.colwise().maxCoeff() - along.colwise().minCoeff()).transpose();
  EXPECT_LT((ranges - goal.ranges).norm(), 1e-9);
  // And it is a scaling along them: coordinate by coordinate.
  const Points expected = e.straight.vertices * goal.ranges.cwiseQuotient(e.ranges).asDiagonal();
  EXPECT_LT((along - expected).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(ScaledToExtents, LeavesAnAxisWithoutRangeAlone) {
  Points square(4, 3), cube(8, 3);
  square << 2, 1, 0, -2, 1, 0, -2, -1, 0, 2, -1, 0;
  cube << 9, 5, 3, -9, 5, 3, 9, -5, 3, 9, 5, -3, -9, -5, 3, -9, 5, -3, 9, -5, -3, -9, -5, -3;
  const Eigen::Matrix3d rotation = test::randomRotation(9);
  const Points turned = square * rotation.transpose();  // its thickness is rounding now, not zero
  const Points scaled = scaledToExtents(turned, principalAxes(cube)) * rotation;
  Points expected(4, 3);
  expected << 9, 5, 0, -9, 5, 0, -9, -5, 0, 9, -5, 0;
  EXPECT_LT((scaled - expected).cwiseAbs().maxCoeff(), 1e-12);
  // A flat reference flattens nothing.
  const Points kept = scaledToExtents(cube, principalAxes(square));
  EXPECT_NEAR(kept.col(2).maxCoeff(), 3, 1e-12);
  EXPECT_NEAR(kept.col(0).maxCoeff(), 2, 1e-12);
}

}  // namespace
}  // namespace sphere_propagation
