// SPDX-License-Identifier: GPL-3.0-only
// How round a surface is.

#include "vcg_ext/mesh/sphere_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/test_meshes.h"

namespace sphere_propagation {
namespace {

Points moved(const Points& points, double scale, const Eigen::RowVector3d& shift) {
  return (scale * points).rowwise() + shift;
}

TEST(SphereFit, FindsSpheresOfAnySizeAndPlace) {
  const Points sphere = test::icosphereMesh(6).vertices;
  EXPECT_LT(deviationFromSphere(sphere), 1e-12);
  EXPECT_LT(deviationFromSphere(moved(sphere, 35, {100, -40, 3})), 1e-12);
  EXPECT_LT(deviationFromSphere(moved(sphere, 1e-6, {0, 0, 1})), 1e-6) << "up to rounding";
}

TEST(SphereFit, FindsTheCentreFromUnevenPoints) {
  const Points sphere = test::icosphereMesh(6).vertices;
  EXPECT_LT(deviationFromSphere(sphere.topRows(sphere.rows() / 3)), 1e-9)
      << "a cap, whose mean is not the centre";
}

TEST(SphereFit, SaysHowFarPointsAreOff) {
  Points dented = test::icosphereMesh(12).vertices;
  dented.row(100) *= 0.9;
  EXPECT_NEAR(deviationFromSphere(dented), 0.1, 1e-3);
  EXPECT_GT(deviationFromSphere(test::ellipsoid(1, 1, 1.1).vertices), 0.02);
}

TEST(SphereFit, FindsNoneInAPlane) {
  Points flat = test::icosphereMesh(6).vertices;
  flat.col(2).setZero();
  EXPECT_TRUE(std::isinf(deviationFromSphere(flat)));
  EXPECT_TRUE(std::isinf(deviationFromSphere(Points::Ones(10, 3))));
}

}  // namespace
}  // namespace sphere_propagation
