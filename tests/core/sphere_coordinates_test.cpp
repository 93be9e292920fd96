// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/sphere_coordinates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/core/test_meshes.h"

namespace sphere_propagation::test {
namespace {

TEST(SphereCoordinates, Axes) {
  const auto expectAt = [](const Vector3& p, double u, double v) {
    const Vector2 t = textureCoordinate(p);
    EXPECT_NEAR(t[0], u, 1e-16);
    EXPECT_NEAR(t[1], v, 1e-16);
  };
  expectAt({1, 0, 0}, 0, 0.5);
  expectAt({0, 1, 0}, 0.25, 0.5);
  expectAt({-1, 0, 0}, 0.5, 0.5);
  expectAt({0, -1, 0}, 0.75, 0.5);
  expectAt({0, 0, 1}, 0, 0);
  expectAt({0, 0, -1}, 0, 1);
  expectAt({-0.0, -0.0, 1}, 0, 0);
  expectAt({std::sqrt(0.5), 0, std::sqrt(0.5)}, 0, 0.25);
}

TEST(SphereCoordinates, ThereAndBack) {
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    const Vector3 p = random.direction();
    const Vector2 t = textureCoordinate(p);
    EXPECT_LT((spherePosition(t) - p).norm(), 1e-15);
  }
}

TEST(SphereCoordinates, PolesAndDateLine) {
  // Beside the poles and on both sides of longitude 0, down to the smallest numbers.
  for (const double z : {-1.0, 1.0})
    for (const double off : {0.0, 5e-324, 1e-300, 1e-160, 1e-20, 1e-9, 1e-5}) {
      const Vector3 p = Vector3(-off, off, z).normalized();
      const Vector2 t = textureCoordinate(p);
      EXPECT_GE(t[1], 0);
      EXPECT_LE(t[1], 1);
      EXPECT_LT((spherePosition(t) - p).norm(), 1e-15);
    }
  for (const double off : {0.0, 5e-324, 1e-300, 1e-20, 1e-17, 1e-16, 1e-9})
    for (const double sign : {-1.0, 1.0}) {
      const Vector2 t = textureCoordinate({1, sign * off, 0});
      EXPECT_GE(t[0], 0);
      EXPECT_LT(t[0], 1);
      EXPECT_LT((spherePosition(t) - Vector3(1, sign * off, 0)).norm(), 1e-15);
    }
}

TEST(SphereCoordinates, IntoTheUnitSquare) {
  Random random(2);
  for (int i = 0; i < 10000; ++i) {
    const Vector2 t = textureCoordinate(random.direction());
    EXPECT_TRUE(t[0] >= 0 && t[0] < 1 && t[1] >= 0 && t[1] <= 1);
  }
}

TEST(SphereCoordinates, AlwaysUnitVectors) {
  Random random(3);
  for (int i = 0; i < 1000; ++i)
    EXPECT_NEAR(spherePosition({random.uniform(-1, 2), random.uniform(-1, 2)}).norm(), 1, 1e-15);
}

}  // namespace
}  // namespace sphere_propagation::test
