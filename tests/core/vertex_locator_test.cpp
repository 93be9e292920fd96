// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/vertex_locator.h"

#include <gtest/gtest.h>

#include "tests/core/test_meshes.h"
#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

using test::Random;

int bruteNearest(const Points& points, const Vector3& x) {
  int best = 0;
  for (int i = 1; i < points.rows(); ++i)
    if ((points.row(i).transpose() - x).squaredNorm() <
        (points.row(best).transpose() - x).squaredNorm())
      best = i;
  return best;
}

Points randomPoints(int count, unsigned seed) {
  Random random(seed);
  Points points(count, 3);
  for (int i = 0; i < count; ++i)
    points.row(i) << random.normal(), random.normal(), 0.1 * random.normal();
  return points;
}

TEST(VertexLocator, FindsTheNearestPoint) {
  const Points points = randomPoints(700, 1), queries = randomPoints(500, 2);
  const VertexLocator locator(points);
  for (int i = 0; i < queries.rows(); ++i) {
    const Vector3 x = queries.row(i).transpose();
    EXPECT_EQ(locator.nearest(x), bruteNearest(points, x)) << "query " << i;
  }
}

TEST(VertexLocator, AnswersTheSmallestIndexOfEquallyNearPoints) {
  // A lattice, asked at its cells' centres, edges' middles and nodes: up to eight points are
  // equally near. Then the same points once more, so that every one is there twice.
  Points points(250, 3), lattice(125, 3);
  for (int i = 0; i < 125; ++i) lattice.row(i) << i % 5, i / 5 % 5, i / 25;
  points << lattice, lattice;
  const VertexLocator locator(points);
  for (double x = 0; x <= 4; x += 0.5)
    for (double y = 0; y <= 4; y += 0.5)
      for (double z = 0; z <= 4; z += 0.5)
        EXPECT_EQ(locator.nearest(Vector3(x, y, z)), bruteNearest(points, {x, y, z}))
            << x << " " << y << " " << z;
}

TEST(VertexLocator, AGuessNeverChangesTheAnswer) {
  const Points points = randomPoints(300, 3), queries = randomPoints(200, 4);
  const VertexLocator locator(points);
  const std::vector<int> plain = locator.nearest(queries);
  Random random(5);
  std::vector<int> wild(plain.size());
  for (int& guess : wild) guess = random.index(300);
  EXPECT_EQ(locator.nearest(queries, wild), plain);
  EXPECT_EQ(locator.nearest(queries, plain), plain);
  // A guess that is equally near but has a larger index.
  Points same = Points::Zero(40, 3);
  EXPECT_EQ(VertexLocator(same).nearest(Vector3(1, 2, 3), 39), 0);
}

TEST(VertexLocator, RefusesNoPoints) { EXPECT_THROW(VertexLocator(Points(0, 3)), ParameterError); }

}  // namespace
}  // namespace sphere_propagation
