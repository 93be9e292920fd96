// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/similarity_tree.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/core/sizes.h"
#include "tests/core/test_meshes.h"
#include "tests/core/test_pool.h"
#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

using test::pool;

using test::Mesh;

/// Ellipsoids whose longest axis is 30 + step[i], of other meshes, each somewhere else.
std::vector<ClosedSurface> family(const std::vector<int>& steps, bool turned) {
  std::vector<ClosedSurface> surfaces;
  for (size_t i = 0; i < steps.size(); ++i) {
    Mesh mesh = test::transformed(test::icosphereMesh(9 + steps[i] % 3),
                                  test::randomRotation(50 + steps[i]), 1, Vector3::Zero());
    mesh.vertices *= Vector3(30 + 2 * steps[i], 20, 12).asDiagonal();
    const auto seed = static_cast<unsigned>(i);
    const Eigen::Matrix3d rotation =
        turned ? test::randomRotation(seed) : Eigen::Matrix3d::Identity();
    surfaces.push_back(surfaceOf(test::transformed(mesh, rotation, 1, Vector3(i, 2, 3))));
  }
  return surfaces;
}

TEST(ShapeDistances, AreNothingBetweenMovedCopies) {
  const Mesh mesh = test::noisyEllipsoid(1);
  std::vector<ClosedSurface> copies{surfaceOf(mesh)};
  for (unsigned seed = 0; seed < 4; ++seed)
    copies.push_back(
        surfaceOf(test::transformed(mesh, test::randomRotation(seed), 1, Vector3(seed, 100, -3))));
  EXPECT_LT(shapeDistances(copies, pool).maxCoeff(), 1e-10);
}

TEST(ShapeDistances, KeepTheScale) {
  const Mesh mesh = test::ellipsoid(10, 10, 10, 6);
  const auto scaled = [&](double scale) {
    return surfaceOf(test::transformed(mesh, Eigen::Matrix3d::Identity(), scale, Vector3::Zero()));
  };
  const Eigen::MatrixXd distances =
      shapeDistances(std::vector<ClosedSurface>{scaled(1), scaled(1.1), scaled(1.3)}, pool);
  EXPECT_NEAR(distances(0, 1), 1, 0.05);
  EXPECT_NEAR(distances(0, 2), 3, 0.15);
  EXPECT_NEAR(distances(1, 2), 2, 0.1);
  EXPECT_EQ(distances, distances.transpose());
  EXPECT_EQ(distances.diagonal(), Eigen::Vector3d::Zero());
}

TEST(ShapeDistances, TurnWithNothing) {
  const std::vector<int> steps = {0, 3, 1, 5};
  const Eigen::MatrixXd here = shapeDistances(family(steps, false), pool),
                        there = shapeDistances(family(steps, true), pool);
  EXPECT_LT((here - there).cwiseAbs().maxCoeff(),
            0.15);  // another start may end a little elsewhere
}

TEST(ShapeDistances, AreTheSameEveryTime) {
  const std::vector<ClosedSurface> surfaces = family({2, 0, 1}, true);
  EXPECT_EQ(shapeDistances(surfaces, pool), shapeDistances(surfaces, pool));
}

TEST(ShapeDistances, OfTheSmallestMeshes) {
  const std::vector<ClosedSurface> surfaces = {surfaceOf(test::tetrahedron()),
                                               surfaceOf(test::octahedron())};
  const Eigen::MatrixXd distances = shapeDistances(surfaces, pool);
  EXPECT_TRUE(distances.allFinite());
  EXPECT_GT(distances(0, 1), 0);
  EXPECT_EQ(shapeDistances(std::vector<ClosedSurface>(), pool).size(), 0);
}

TEST(ShapeDistances, OfManyCompareEachWithItsLikeAlone) {
  std::vector<int> steps;  // 0 .. 29, shuffled
  for (int i = 0; i < 30; ++i) steps.push_back(7 * i % 30);
  const Sequence sequence = family(steps, true);
  ShapeComparison few;
  few.allPairsUpTo = 10;
  few.sample = 4;
  few.neighbours = 5;
  const Eigen::MatrixXd all = shapeDistances(sequence, pool),
                        some = shapeDistances(sequence, pool, few);
  EXPECT_TRUE(all.allFinite());
  int compared = 0;
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 30; ++j)
      if (std::isfinite(some(i, j))) {
        EXPECT_EQ(some(i, j), all(i, j)) << i << ", " << j;
        ++compared;
      }
  EXPECT_EQ(some, some.transpose());
  EXPECT_LE(compared, 30 * 2 * (4 + 5) + 30);
  for (int j : {0, 7, 15, 22}) EXPECT_TRUE(some.col(j).allFinite()) << j;  // the sample
  for (int root : {0, 11}) {
    const PropagationTree tree = minimumSpanningTree(some, root);
    for (int i = 0; i < 30; ++i)
      if (i != root) {
        EXPECT_EQ(std::abs(steps[i] - steps[tree.parent[i]]), 1) << i << " <- " << tree.parent[i];
      }
  }
  // The middle of the family is 14 or 15; four of thirty say it nearly.
  EXPECT_NEAR(steps[mostCentral(all)], 14.5, 1);
  EXPECT_NEAR(steps[mostCentral(some)], 14.5, 4.5);
}

Eigen::MatrixXd fourSurfaces() {
  Eigen::MatrixXd d(4, 4);
  d << 0, 1, 4, 9,  //
      1, 0, 2, 5,   //
      4, 2, 0, 3,   //
      9, 5, 3, 0;
  return d;
}

TEST(MostCentral, ByHand) {
  Eigen::MatrixXd d = fourSurfaces();
  EXPECT_EQ(mostCentral(d), 1);  // 14, 8, 9, 17
  d(1, 3) = d(3, 1) = std::numeric_limits<double>::infinity();
  // Only 0 and 2 were compared with all: means of the distances from these are 4, 1.5, 4, 6.
  EXPECT_EQ(mostCentral(d), 1);
  d(0, 1) = d(1, 0) = 8;  // now 4, 5, 4, 6
  EXPECT_EQ(mostCentral(d), 0);
  EXPECT_EQ(mostCentral(Eigen::MatrixXd::Zero(1, 1)), 0);
}

TEST(MinimumSpanningTree, ByHand) {
  const PropagationTree tree = minimumSpanningTree(fourSurfaces(), 2);
  EXPECT_EQ(tree.parent, (std::vector<int>{1, 2, -1, 2}));
  EXPECT_EQ(tree.order, (std::vector<int>{2, 1, 0, 3}));
}

TEST(MinimumSpanningTree, IsNoLongerThanAnyOther) {
  test::Random random(4);
  const int n = 5;
  for (int trial = 0; trial < 20; ++trial) {
    Eigen::MatrixXd d = Eigen::MatrixXd::Zero(n, n);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < i; ++j) d(i, j) = d(j, i) = random.uniform();
    const int root = random.index(n);
    const PropagationTree tree = minimumSpanningTree(d, root);
    double length = 0;
    for (int i = 0; i < n; ++i)
      if (i != root) length += d(i, tree.parent[i]);
    // All n^(n-1) lists of parents, those that are trees.
    for (int code = 0; code < 5 * 5 * 5 * 5 * 5; ++code) {
      std::vector<int> parent(n);
      for (int i = 0, rest = code; i < n; ++i, rest /= n) parent[i] = rest % n;
      parent[root] = -1;
      double other = 0;
      bool isTree = true;
      for (int i = 0; i < n; ++i) {
        int at = i, steps = 0;
        while (at >= 0 && steps++ <= n) at = parent[at];
        isTree = isTree && at < 0;
        if (i != root) other += d(i, parent[i]);
      }
      if (isTree) {
        ASSERT_LE(length, other + 1e-15);
      }
    }
    EXPECT_EQ(givenOrder(tree.parent).root(), root);
  }
}

TEST(MinimumSpanningTree, EqualDistancesMakeAStar) {
  const Eigen::MatrixXd d = Eigen::MatrixXd::Ones(4, 4) - Eigen::MatrixXd::Identity(4, 4);
  EXPECT_EQ(minimumSpanningTree(d, 0).parent, (std::vector<int>{-1, 0, 0, 0}));
  EXPECT_EQ(minimumSpanningTree(d, 0).order, (std::vector<int>{0, 1, 2, 3}));
}

TEST(MinimumSpanningTree, RefusesWhatIsNone) {
  EXPECT_THROW(minimumSpanningTree(Eigen::MatrixXd::Zero(3, 2), 0), ParameterError);
  EXPECT_THROW(minimumSpanningTree(Eigen::MatrixXd::Zero(0, 0), 0), ParameterError);
  EXPECT_THROW(minimumSpanningTree(Eigen::MatrixXd::Zero(3, 3), 3), ParameterError);
  EXPECT_THROW(minimumSpanningTree(Eigen::MatrixXd::Zero(3, 3), -1), ParameterError);
  Eigen::MatrixXd d = Eigen::MatrixXd::Zero(3, 3);
  d(0, 1) = 1;
  EXPECT_THROW(minimumSpanningTree(d, 0), ParameterError);
  d(1, 0) = d(0, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(minimumSpanningTree(d, 0), ParameterError);
  const double none = std::numeric_limits<double>::infinity();
  d << 0, 1, none, 1, 0, none, none, none, 0;
  EXPECT_THROW(minimumSpanningTree(d, 0), ParameterError);  // nothing leads to the last
}

TEST(MinimumSpanningTree, GoesRoundWhatWasNotCompared) {
  const double none = std::numeric_limits<double>::infinity();
  Eigen::MatrixXd d(3, 3);
  d << 0, 5, none, 5, 0, 1, none, 1, 0;
  EXPECT_EQ(minimumSpanningTree(d, 0).parent, (std::vector<int>{-1, 0, 1}));
}

TEST(SimilarityTree, AFamilyOfEllipsoidsIsAChain) {
  const std::vector<int> steps = {3, 0, 5, 1, 6, 2, 4};  // shuffled
  for (bool turned : {false, true})
    for (int root = 0; root < 7; ++root) {
      const SimilarityTree similarity = similarityTree(family(steps, turned), root, pool);
      EXPECT_EQ(similarity.tree.root(), root);
      for (int i = 0; i < 7; ++i) {
        if (i == root) continue;
        const int parent = similarity.tree.parent[i];
        EXPECT_EQ(std::abs(steps[i] - steps[parent]), 1) << i << " <- " << parent;
      }
    }
}

TEST(SimilarityTree, OfManyIsNearlyTheShortest) {
  test::Random random(11);
  std::vector<ClosedSurface> surfaces;  // in no order, and on no line
  for (int i = 0; i < test::sizeFor(60, 25); ++i) {
    Mesh mesh = test::icosphereMesh(6);
    mesh.vertices *=
        Vector3(30 + 12 * random.uniform(), 18 + 6 * random.uniform(), 10 + 4 * random.uniform())
            .asDiagonal();
    surfaces.push_back(surfaceOf(mesh));
  }
  ShapeComparison few;
  few.allPairsUpTo = 10;
  few.sample = 10;
  few.neighbours = 6;
  const Eigen::MatrixXd all = shapeDistances(surfaces, pool);
  const auto length = [&](const PropagationTree& tree) {
    double sum = 0;
    for (int i = 0; i < tree.size(); ++i)
      if (i != tree.root()) sum += all(i, tree.parent[i]);
    return sum;
  };
  const double shortest = length(minimumSpanningTree(all, 0)),
               found = length(minimumSpanningTree(shapeDistances(surfaces, pool, few), 0));
  EXPECT_GE(found, shortest);
  EXPECT_LE(found, 1.05 * shortest);
}

TEST(SimilarityTree, OneLayerAndNone) {
  const std::vector<ClosedSurface> one = family({0}, false);
  EXPECT_EQ(similarityTree(one, 0, pool).tree.parent, (std::vector<int>{-1}));
  EXPECT_THROW(similarityTree(one, 1, pool), ParameterError);
  EXPECT_THROW(similarityTree(std::vector<ClosedSurface>(), 0, pool), ParameterError);
}

}  // namespace
}  // namespace sphere_propagation
