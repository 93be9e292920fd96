// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/published/mutual_nearest.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/core/test_meshes.h"

namespace sphere_propagation {
namespace {

int bruteNearest(const Points& points, const Vector3& x) {
  int best = 0;
  for (int i = 1; i < points.rows(); ++i)
    if ((points.row(i).transpose() - x).squaredNorm() <
        (points.row(best).transpose() - x).squaredNorm())
      best = i;
  return best;
}

std::vector<VertexPair> brutePairs(const Points& target, const Points& reference) {
  std::vector<VertexPair> pairs;
  for (int v = 0; v < target.rows(); ++v) {
    const int w = bruteNearest(reference, target.row(v).transpose());
    if (bruteNearest(target, reference.row(w).transpose()) == v) pairs.push_back({v, w});
  }
  return pairs;
}

TEST(MutualNearest, AgreesWithBruteForceOnRandomClouds) {
  test::Random random(1);
  for (int round = 0; round < 5; ++round) {
    Points target(150, 3), reference(100 + 40 * round, 3);
    for (Points* points : {&target, &reference})
      for (int i = 0; i < points->rows(); ++i)
        points->row(i) << random.normal(), random.normal(), random.normal();
    const std::vector<VertexPair> pairs =
        mutualNearest(VertexLocator(target), VertexLocator(reference));
    EXPECT_EQ(pairs, brutePairs(target, reference));
    EXPECT_GT(pairs.size(), 20u);
    EXPECT_LT(pairs.size(), 150u);  // some are nearest one way only, or this would test little
  }
}

TEST(MutualNearest, IsUniqueOnBothSidesWhereDistancesTie) {
  // Two lattices, shifted by half a cell: every point has eight nearest ones.
  Points target(64, 3), reference(64, 3);
  for (int i = 0; i < 64; ++i) target.row(i) << i % 4, i / 4 % 4, i / 16;
  reference = target.array() + 0.5;
  const std::vector<VertexPair> pairs =
      mutualNearest(VertexLocator(target), VertexLocator(reference));
  EXPECT_EQ(pairs, brutePairs(target, reference));
  ASSERT_FALSE(pairs.empty());
  std::set<int> left, right;
  for (const VertexPair& pair : pairs) {
    EXPECT_TRUE(left.insert(pair.target).second);
    EXPECT_TRUE(right.insert(pair.reference).second);
  }
}

TEST(MutualNearest, LeavesOutWhatIsNearestOneWayOnly) {
  Points target(2, 3), reference(2, 3);
  target << 0, 0, 0, 1, 0, 0;
  reference << 1.1, 0, 0, 9, 0,
      0;  // both targets are nearest to reference 0, which is nearest to target 1
  EXPECT_EQ(mutualNearest(VertexLocator(target), VertexLocator(reference)),
            (std::vector<VertexPair>{{1, 0}}));
}

}  // namespace
}  // namespace sphere_propagation
