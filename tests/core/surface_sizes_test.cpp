// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/surface_sizes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/core/test_meshes.h"

namespace sphere_propagation {
namespace {

/// Spheres of these radii, about (100, 0, 0) times their factor.
Sequence spheres(const std::vector<double>& radii, const std::vector<double>& factors = {}) {
  std::vector<ClosedSurface> surfaces;
  for (size_t i = 0; i < radii.size(); ++i) {
    const double factor = factors.empty() ? 1 : factors[i];
    surfaces.push_back(
        surfaceOf(test::transformed(test::icosphereMesh(2), Eigen::Matrix3d::Identity(),
                                    factor * radii[i], factor * Vector3(100, 0, 0))));
  }
  return surfaces;
}

std::vector<int> standingOut(const std::vector<double>& radii, const PropagationTree& tree) {
  const std::vector<SurfaceSize> sizes = findSurfaceSizes(spheres(radii), tree);
  std::vector<int> found;
  for (size_t i = 0; i < sizes.size(); ++i)
    if (sizes[i].standsOut) found.push_back(static_cast<int>(i));
  return found;
}

/// A cavity's cycle of so many phases.
std::vector<double> beating(int phases) {
  std::vector<double> radii;
  for (int t = 0; t < phases; ++t)
    radii.push_back(35 * std::exp(-0.36 * std::pow(std::sin(pi * t / phases), 2)));
  return radii;
}

using List = std::vector<int>;

TEST(SurfaceSizes, WhatBeatsOrDiffersAsSpeciesDoStandsOutNowhere) {
  for (int phases = 2; phases <= 25; ++phases)
    for (const PropagationTree& tree : {timeOrder(phases, 0), cyclicTimeOrder(phases, 0),
                                        star(phases, 0), star(phases, phases / 2)})
      EXPECT_EQ(standingOut(beating(phases), tree), List{}) << phases;
  // Of skulls, in the order of their files.
  const std::vector<double> skulls{9.6, 6.3, 6.6, 7.6, 9.8, 10.7, 8, 6.8, 9.4, 9, 6.9, 7.4};
  EXPECT_EQ(standingOut(skulls, star(12, 0)), List{});
  EXPECT_EQ(standingOut(skulls, timeOrder(12, 5)), List{});
  EXPECT_EQ(standingOut({10.7, 6.3}, timeOrder(2, 0)), List{});
}

TEST(SurfaceSizes, OneInAnotherUnitStandsOutEitherWay) {
  for (const double factor : {0.01, 1 / 25.4, 0.1, 0.25, 3.0, 5.0, 10.0, 25.4, 1000.0})
    for (const int phases : {3, 4, 6, 12, 25})
      for (int odd = 0; odd < phases; odd += phases / 3) {
        std::vector<double> radii = beating(phases);
        radii[static_cast<size_t>(odd)] *= factor;
        for (const PropagationTree& tree :
             {timeOrder(phases, 0), cyclicTimeOrder(phases, 1), star(phases, phases / 2)})
          EXPECT_EQ(standingOut(radii, tree), List{odd}) << factor << " " << phases << " " << odd;
      }
}

TEST(SurfaceSizes, TwiceAsLargeAsTheNeighboursInTimeStandsOut) {
  std::vector<double> radii = beating(12);
  radii[6] *= 2;  // as large as end-diastole nearly
  EXPECT_EQ(standingOut(radii, timeOrder(12, 0)), List{6});
  radii = beating(12);
  radii[0] /= 2;
  EXPECT_EQ(standingOut(radii, cyclicTimeOrder(12, 0)), List{0});
}

TEST(SurfaceSizes, ABumpInASlowSequenceStandsOut) {
  for (const double factor : {0.6, 1.5, 1.8})
    for (const int phases : {12, 25})
      for (int odd = 1; odd + 1 < phases; ++odd) {
        std::vector<double> radii = beating(phases);
        radii[static_cast<size_t>(odd)] *= factor;
        for (const PropagationTree& tree : {timeOrder(phases, 0), cyclicTimeOrder(phases, 0)})
          if (tree.children()[static_cast<size_t>(odd)].size() == 1) {  // not a branch's end
            EXPECT_EQ(standingOut(radii, tree), List{odd}) << factor << " " << phases << " " << odd;
          }
      }
}

TEST(SurfaceSizes, SeveralOfAnotherUnitAreNotTheRule) {
  std::vector<double> radii = beating(8);
  for (const size_t i : {2, 3, 6}) radii[i] /= 10;
  EXPECT_EQ(standingOut(radii, timeOrder(8, 0)), (List{2, 3, 6}));
  EXPECT_EQ(standingOut(radii, timeOrder(8, 3)), (List{2, 3, 6}));
  for (const size_t i : {5}) radii[i] /= 10;  // half of them: the root is right
  EXPECT_EQ(standingOut(radii, timeOrder(8, 0)), (List{2, 3, 5, 6}));
  EXPECT_EQ(standingOut(radii, timeOrder(8, 2)), (List{0, 1, 4, 7}));
}

TEST(SurfaceSizes, OfTwoTheRootIsRight) {
  EXPECT_EQ(standingOut({30, 3}, timeOrder(2, 0)), List{1});
  EXPECT_EQ(standingOut({30, 3}, timeOrder(2, 1)), List{0});
}

TEST(SurfaceSizes, TheUnitIsThatOfTheFactor) {
  const auto units = [](double factor) {
    std::vector<double> radii = beating(6);
    radii[2] *= factor;
    return findSurfaceSizes(spheres(radii), timeOrder(6, 0))[2];
  };
  EXPECT_EQ(units(0.1).units, 10);
  EXPECT_EQ(units(0.1).toOthers(), 10);
  EXPECT_EQ(units(25.4).units, 25.4);
  EXPECT_EQ(units(25.4).toOthers(), 1 / 25.4);
  EXPECT_EQ(units(100).units, 100);
  EXPECT_EQ(units(0.001).units, 1000);
  EXPECT_EQ(units(3).units, 0);
  EXPECT_NEAR(units(3).toOthers(), 1 / 3.0, 0.05);
  EXPECT_EQ(units(1).toOthers(), 1);
}

TEST(SurfaceSizes, WhatStandsOutIsScaledAsAnotherUnitWouldBeOrInItsPlace) {
  const std::vector<double> radii(4, 30);
  // In cm, about the origin; twice the root, which the others are to fit.
  Sequence sequence = spheres(radii, {1, 1, 0.1, 1});
  PropagationTree tree = timeOrder(4, 0);
  Sequence sized = inRootsSize(sequence, findSurfaceSizes(sequence, tree), tree);
  EXPECT_NEAR((sized[2].centre() - Vector3(100, 0, 0)).norm(), 0, 1e-9);
  EXPECT_NEAR(sized[2].radius(), sized[0].radius(), 1e-9);
  tree = timeOrder(4, 2);
  sized = inRootsSize(sequence, findSurfaceSizes(sequence, tree), tree);
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR((sized[i].centre() - Vector3(10, 0, 0)).norm(), 0, 1e-9) << i;
    EXPECT_NEAR(sized[i].radius(), sequence[2].radius(), 1e-9) << i;
  }
  // Three times as large where it is.
  sequence = spheres({30, 30, 90, 30});
  tree = timeOrder(4, 0);
  sized = inRootsSize(sequence, findSurfaceSizes(sequence, tree), tree);
  EXPECT_NEAR((sized[2].centre() - Vector3(100, 0, 0)).norm(), 0, 1e-9);
}

}  // namespace
}  // namespace sphere_propagation
