// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/kernel_placement.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tests/core/test_meshes.h"
#include "vcg_ext/sphere/spherical_triangle.h"

namespace sphere_propagation::test {
namespace {

constexpr double least = 1e-13;

double minDeterminant(const std::vector<Vector3>& rim, const Vector3& x) {
  double smallest = 1;
  for (size_t i = 0; i < rim.size(); ++i)
    smallest = std::min(smallest, x.dot(rim[i].cross(rim[(i + 1) % rim.size()])));
  return smallest;
}

/// A polygon that its corner 0 sees whole: the fan of triangles from there is positive.
std::vector<Vector3> fan(Random& random, int sides, double size) {
  const Vector3 centre = random.direction();
  Vector3 t1, t2;
  tangentFrame(centre, t1, t2);
  std::vector<Vector3> rim{centre};
  for (int i = 0; i < sides; ++i) {
    const double angle = 0.2 + 2.6 * i / sides + random.uniform(0, 2.0 / sides),
                 radius = size * random.uniform(0.05, 1);
    rim.push_back((centre + radius * (std::cos(angle) * t1 + std::sin(angle) * t2)).normalized());
  }
  return rim;
}

TEST(KernelPlacement, FindsAPlaceThatSeesTheWholeRim) {
  Random random(1);
  for (const double size : {1.0, 0.1, 1e-4})
    for (int i = 0; i < 200; ++i) {
      const std::vector<Vector3> rim = fan(random, 2 + random.index(9), size);
      Vector3 x;
      ASSERT_TRUE(placeInKernel(rim, rim[0], 1e-30, x)) << "size " << size << ", polygon " << i;
      EXPECT_NEAR(x.norm(), 1, 1e-14);
      EXPECT_GT(minDeterminant(rim, x), 0);
    }
}

TEST(KernelPlacement, IsTheCentroidOfAConvexPolygon) {
  std::vector<Vector3> rim;
  for (int i = 0; i < 7; ++i)
    rim.push_back(Vector3(std::cos(2 * pi * i / 7), std::sin(2 * pi * i / 7), 5).normalized());
  Vector3 x;
  ASSERT_TRUE(placeInKernel(rim, Vector3::UnitZ(), least, x));
  EXPECT_LT((x - Vector3::UnitZ()).norm(), 1e-12);
}

TEST(KernelPlacement, WorksForRingsOfThousandsAndBeyondAHemisphere) {
  std::vector<Vector3> rim;
  for (int i = 0; i < 5000; ++i)
    rim.push_back(
        Vector3(std::cos(2 * pi * i / 5000), std::sin(2 * pi * i / 5000), -0.2).normalized());
  for (const Vector3& near : {Vector3(Vector3::UnitZ()), rim[0]}) {
    Vector3 x;
    ASSERT_TRUE(placeInKernel(rim, near, least, x));
    EXPECT_GT(minDeterminant(rim, x), 0);
  }
}

TEST(KernelPlacement, SaysSoWhenThereIsNone) {
  // A star whose points are turned so far that no place sees both sides of each.
  std::vector<Vector3> rim;
  for (int i = 0; i < 10; ++i) {
    const double angle = 2 * pi * i / 10 + (i % 2 == 0 ? 0.0 : 1.2),
                 radius = i % 2 == 0 ? 0.1 : 1.0;
    rim.push_back(Vector3(radius * std::cos(angle), radius * std::sin(angle), 3).normalized());
  }
  Vector3 x;
  EXPECT_FALSE(placeInKernel(rim, rim[0], least, x));
  std::reverse(rim.begin(), rim.end());
  EXPECT_FALSE(placeInKernel(rim, rim[0], least, x));
}

}  // namespace
}  // namespace sphere_propagation::test
