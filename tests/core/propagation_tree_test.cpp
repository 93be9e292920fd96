// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/propagation_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

using Arcs = std::set<std::pair<int, int>>;

Arcs arcsOf(const PropagationTree& tree) {
  Arcs arcs;
  for (int i = 0; i < tree.size(); ++i)
    if (tree.parent[i] >= 0) arcs.emplace(tree.parent[i], i);
  return arcs;
}

/// Every layer once, the root first, parents before children.
void expectOrdered(const PropagationTree& tree, int root) {
  ASSERT_EQ(tree.order.size(), tree.parent.size());
  EXPECT_EQ(tree.root(), root);
  EXPECT_EQ(tree.parent[root], -1);
  std::set<int> done;
  for (int i : tree.order) {
    EXPECT_TRUE(i == root || done.count(tree.parent[i]))
        << "layer " << i << " comes before its parent";
    EXPECT_TRUE(done.insert(i).second) << "layer " << i << " comes twice";
  }
}

std::string messageOf(const std::vector<int>& parents) {
  try {
    givenOrder(parents);
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "no error";
}

TEST(PropagationTree, TimeOrderIsStepTwoOfThePaper) {
  const PropagationTree tree = timeOrder(5, 2);
  EXPECT_EQ(arcsOf(tree), (Arcs{{2, 1}, {1, 0}, {2, 3}, {3, 4}}));
  expectOrdered(tree, 2);
  EXPECT_EQ(tree.depths(), (std::vector<int>{2, 1, 0, 1, 2}));
  EXPECT_EQ(tree.levels(), (std::vector<std::vector<int>>{{2}, {1, 3}, {0, 4}}));
  EXPECT_EQ(tree.children(), (std::vector<std::vector<int>>{{}, {0}, {1, 3}, {4}, {}}));
}

TEST(PropagationTree, TimeOrderFromEveryRoot) {
  for (int layers : {1, 2, 3, 8})
    for (int root = 0; root < layers; ++root) {
      const PropagationTree tree = timeOrder(layers, root);
      expectOrdered(tree, root);
      Arcs expected;
      for (int i = 0; i + 1 < layers; ++i)  // the paper's two rules
        expected.insert(i < root ? std::pair(i + 1, i) : std::pair(i, i + 1));
      EXPECT_EQ(arcsOf(tree), expected) << layers << " layers, root " << root;
    }
}

TEST(PropagationTree, DefaultRootIsHalfTheNumberOfLayers) {
  EXPECT_EQ(defaultRoot(1), 0);
  EXPECT_EQ(defaultRoot(2), 1);
  EXPECT_EQ(defaultRoot(5), 2);
  EXPECT_EQ(defaultRoot(25), 12);
  EXPECT_THROW(defaultRoot(0), ParameterError);
}

TEST(PropagationTree, CyclicOrderGoesBothWaysRound) {
  EXPECT_EQ(arcsOf(cyclicTimeOrder(5, 0)), (Arcs{{0, 1}, {1, 2}, {0, 4}, {4, 3}}));
  EXPECT_EQ(arcsOf(cyclicTimeOrder(6, 0)), (Arcs{{0, 1}, {1, 2}, {2, 3}, {0, 5}, {5, 4}}));
  EXPECT_EQ(arcsOf(cyclicTimeOrder(5, 3)), (Arcs{{3, 4}, {4, 0}, {3, 2}, {2, 1}}));
  EXPECT_EQ(arcsOf(cyclicTimeOrder(1, 0)), Arcs{});
  EXPECT_EQ(arcsOf(cyclicTimeOrder(2, 1)), (Arcs{{1, 0}}));
  EXPECT_EQ(arcsOf(cyclicTimeOrder(3, 1)), (Arcs{{1, 2}, {1, 0}}));
}

TEST(PropagationTree, NoCyclicChainIsLongerThanHalfTheCycle) {
  for (int layers : {1, 2, 3, 24, 25})
    for (int root = 0; root < layers; ++root) {
      const PropagationTree tree = cyclicTimeOrder(layers, root);
      expectOrdered(tree, root);
      const std::vector<int> depths = tree.depths();
      EXPECT_EQ(*std::max_element(depths.begin(), depths.end()), layers / 2);
    }
}

TEST(PropagationTree, TheClosingArcIsTheOneThatTheCycleLacks) {
  for (int layers = 2; layers < 9; ++layers)
    for (int root = 0; root < layers; ++root) {
      const PropagationTree tree = cyclicTimeOrder(layers, root);
      const Arc arc = closingArc(layers, root);
      EXPECT_EQ(arc.to, (arc.from + 1) % layers);
      EXPECT_TRUE(tree.children()[arc.from].empty());
      if (layers == 2) continue;  // there and back
      EXPECT_NE(tree.parent[arc.from], arc.to);
      EXPECT_NE(tree.parent[arc.to], arc.from);
    }
}

TEST(PropagationTree, ACycleIsClosedByItsArc) {
  for (int layers = 2; layers < 9; ++layers)
    for (int root = 0; root < layers; ++root) {
      const ClosedCycle cycle =
          closedCycle(cyclicTimeOrder(layers, root), closingArc(layers, root));
      ASSERT_EQ(cycle.layers.size(), static_cast<size_t>(layers));
      for (int step = 0; step < layers; ++step)
        EXPECT_EQ(cycle.layers[step], (root + step) % layers);
      EXPECT_EQ(cycle.forward, layers / 2);
      std::vector<int> reached;
      for (const bool forward : {true, false})
        for (const auto& [from, to] : cycle.arcsBeyond(forward)) {
          EXPECT_EQ(to, (from + (forward ? 1 : layers - 1)) % layers);
          reached.push_back(to);
        }
      std::sort(reached.begin(), reached.end());
      std::vector<int> others;
      for (int i = 0; i < layers; ++i)
        if (i != root) others.push_back(i);
      EXPECT_EQ(reached, others);  // each layer comes the other way round, too
    }
  EXPECT_EQ(closedCycle(timeOrder(4, 0), {3, 0}).forward, 3);
  EXPECT_TRUE(closedCycle(star(4, 0), {1, 2}).layers.empty());
  EXPECT_TRUE(closedCycle(timeOrder(5, 2), {3, 1}).layers.empty());  // 4 and 0 are left out
  EXPECT_TRUE(closedCycle(timeOrder(4, 0), {3, 1}).layers.empty());  // 1 would come twice
}

TEST(PropagationTree, TheCentreIsTheBestRootOfTheSameTree) {
  EXPECT_EQ(timeOrder(9, 0).centre(), 4);
  EXPECT_EQ(timeOrder(9, 0).farthestFrom(0), 8);
  EXPECT_EQ(timeOrder(9, 0).farthestFrom(4), 4);
  EXPECT_EQ(timeOrder(8, 4).centre(), 4);  // as good as 3
  EXPECT_EQ(star(5, 2).centre(), 2);
  EXPECT_EQ(cyclicTimeOrder(9, 3).centre(), 3);
  EXPECT_EQ(givenOrder({-1, 0, 1, 2, 2, 2}).centre(), 1);
  EXPECT_EQ(timeOrder(1, 0).centre(), 0);
}

TEST(PropagationTree, StarHangsEveryLayerOnTheRoot) {
  const PropagationTree tree = star(4, 1);
  EXPECT_EQ(tree.parent, (std::vector<int>{1, -1, 1, 1}));
  EXPECT_EQ(tree.depths(), (std::vector<int>{1, 0, 1, 1}));
  expectOrdered(tree, 1);
  expectOrdered(star(1, 0), 0);
}

TEST(PropagationTree, GivenOrderKeepsTheArcsAndSortsParentsFirst) {
  const std::vector<int> parents{3, 0, 1, 5, 3, -1};
  const PropagationTree tree = givenOrder(parents);
  EXPECT_EQ(tree.parent, parents);
  expectOrdered(tree, 5);
  EXPECT_EQ(tree.depths(), (std::vector<int>{2, 3, 4, 1, 2, 0}));
}

TEST(PropagationTree, GivenOrderNamesTheLayerThatIsWrong) {
  EXPECT_NE(messageOf({1, 2, 0}).find("No surface is marked as the root"), std::string::npos);
  EXPECT_NE(messageOf({-1, 0, -1}).find("Surface 2"), std::string::npos);
  EXPECT_NE(messageOf({-1, 7}).find("Surface 1"), std::string::npos);
  EXPECT_NE(messageOf({-1, 7}).find("surface 7"), std::string::npos);
  EXPECT_NE(messageOf({-1, -2}).find("Surface 1"), std::string::npos);
  EXPECT_NE(messageOf({-1, 1}).find("1 <- 1"), std::string::npos);  // its own parent
  // Layer 1 is behind the circle, not on it.
  EXPECT_NE(messageOf({-1, 2, 3, 4, 2}).find("2 <- 3 <- 4 <- 2"), std::string::npos)
      << messageOf({-1, 2, 3, 4, 2});
  EXPECT_THROW(givenOrder({}), ParameterError);
}

TEST(PropagationTree, RefusesARootOutOfRange) {
  EXPECT_THROW(timeOrder(3, 3), ParameterError);
  EXPECT_THROW(timeOrder(3, -1), ParameterError);
  EXPECT_THROW(cyclicTimeOrder(0, 0), ParameterError);
  EXPECT_THROW(star(2, 2), ParameterError);
}

}  // namespace
}  // namespace sphere_propagation
