// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/display/colors.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/core/test_meshes.h"

namespace sphere_propagation {
namespace {

Eigen::RowVector3i color(double value, double range) {
  return displacementColors(Eigen::VectorXd::Constant(1, value), range).row(0).cast<int>();
}

TEST(NormalDisplacements, AreSignedAlongTheNormal) {
  const auto sphere = test::icosphereMesh(3);
  const Points larger = 1.25 * sphere.vertices, smaller = 0.5 * sphere.vertices;
  EXPECT_NEAR(normalDisplacements(sphere.vertices, larger, sphere.faces).minCoeff(), 0.25, 0.01);
  EXPECT_NEAR(normalDisplacements(sphere.vertices, smaller, sphere.faces).maxCoeff(), -0.5, 0.01);
  Points turned = sphere.vertices;
  turned.col(0) += 0.01 * sphere.vertices.col(1);
  turned.col(1) -=
      0.01 * sphere.vertices.col(0);  // about the z axis, to first order: along the surface
  EXPECT_LT(normalDisplacements(sphere.vertices, turned, sphere.faces).cwiseAbs().maxCoeff(),
            0.001);
}

TEST(DisplacementColors, RunFromBlueOverWhiteToRed) {
  EXPECT_EQ(color(-2, 2), Eigen::RowVector3i(33, 102, 172));
  EXPECT_EQ(color(0, 2), Eigen::RowVector3i(247, 247, 247));
  EXPECT_EQ(color(2, 2), Eigen::RowVector3i(178, 24, 43));
  EXPECT_EQ(color(1, 2), Eigen::RowVector3i(244, 165, 130));
  EXPECT_EQ(color(9, 2), color(2, 2));
  EXPECT_EQ(color(-9, 2), color(-2, 2));
  for (int i = 0; i < 100; ++i) {  // the farther out, the less blue; the farther in, the less red
    EXPECT_LE(color((i + 1) / 100.0, 1)[2], color(i / 100.0, 1)[2]);
    EXPECT_LE(color(-(i + 1) / 100.0, 1)[0], color(-i / 100.0, 1)[0]);
  }
}

TEST(DisplacementColors, AreWhiteWithoutARange) {
  EXPECT_EQ(color(1, 0), color(0, 1));
  EXPECT_EQ(color(std::numeric_limits<double>::quiet_NaN(), 1), color(0, 1));
}

}  // namespace
}  // namespace sphere_propagation
