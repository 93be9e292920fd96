// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_propagation.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/core/sizes.h"
#include "tests/core/test_meshes.h"
#include "tests/core/test_pool.h"

namespace sphere_propagation {
namespace {

using test::pool;

/// A contracting ellipsoid, images of one sphere: the map of each phase is known.
struct Contraction {
  std::vector<ClosedSurface> surfaces;
  std::vector<Points> maps;
  explicit Contraction(int layers, const Eigen::Matrix3d& rotation = Eigen::Matrix3d::Identity(),
                       double scale = 1) {
    for (int i = 0; i < layers; ++i) {
      const test::Mesh sphere = test::transformed(test::icosphereMesh(test::sizeFor(8, 5) + i % 2),
                                                  test::randomRotation(70 + i), 1, Vector3::Zero());
      const double c = 0.25 * std::sin(3.14159265358979323846 * i / layers);
      test::Mesh mesh = sphere;
      mesh.vertices *= Vector3(40 * (1 - 0.5 * c), 28 * (1 - c), 20 * (1 - c)).asDiagonal();
      mesh = test::transformed(mesh, rotation, scale, Vector3::Zero());
      maps.push_back(sphere.vertices);
      surfaces.emplace_back(mesh.vertices, mesh.faces, "phase " + std::to_string(i));
    }
  }
  FollowedMotion follow(const PropagationTree& tree, const std::optional<Arc>& closing = {},
                        bool smooths = MotionParameters().smooths) const {
    MotionParameters parameters;
    parameters.smooths = smooths;
    return followMotion(surfaces, MappedSurface(surfaces[0], maps[0]), tree, pool, {}, closing,
                        parameters);
  }
};

TEST(MotionPropagation, ToTheSameSurfaceIsTheIdentity) {
  const Contraction one(1);
  const std::vector<ClosedSurface> twice = {one.surfaces[0], one.surfaces[0]};
  const FollowedMotion followed =
      followMotion(twice, MappedSurface(twice[0], one.maps[0]), star(2, 0), pool);
  ASSERT_TRUE(followed.layers[1]);
  EXPECT_FALSE(followed.layers[0]);
  EXPECT_LT(
      (followed.layers[1]->transferred.map.positions() - one.maps[0]).rowwise().norm().maxCoeff(),
      0.02);
}

TEST(MotionPropagation, FollowsAContraction) {
  const Contraction sequence(12);
  const FollowedMotion followed = sequence.follow(cyclicTimeOrder(12, 0));
  ASSERT_TRUE(followed.learnt);
  for (int t = 1; t < 12; ++t) {
    ASSERT_TRUE(followed.layers[t]) << t;
    const Points& found = followed.layers[t]->transferred.map.positions();
    EXPECT_LT((found - sequence.maps[t]).rowwise().norm().mean(), 0.03)
        << t;  // about a degree and a half
  }
}

TEST(MotionPropagation, LearnsWhereThereIsEnoughToLearnFrom) {
  if (test::underThreadSanitizer()) GTEST_SKIP() << "the threads of FollowsAContraction";
  EXPECT_FALSE(Contraction(11).follow(timeOrder(11, 0)).learnt);
  EXPECT_TRUE(Contraction(12).follow(timeOrder(12, 0)).learnt);
}

TEST(MotionPropagation, TurnsWithTheSurfacesAndHasNoUnit) {
  if (test::underThreadSanitizer()) GTEST_SKIP() << "the threads of FollowsAContraction";
  const PropagationTree tree = cyclicTimeOrder(12, 0);
  const FollowedMotion here = Contraction(12).follow(tree);
  const FollowedMotion there = Contraction(12, test::randomRotation(5), 1000).follow(tree);
  for (int t = 1; t < 12; ++t)
    EXPECT_LT(
        (here.layers[t]->transferred.map.positions() - there.layers[t]->transferred.map.positions())
            .rowwise()
            .norm()
            .maxCoeff(),
        1e-5);  // the sums over nodes are in single precision
}

TEST(MotionPropagation, GivesUpLayersThatItLosesButNotThoseBehind) {
  Contraction sequence(4);
  test::Mesh far{sequence.surfaces[2].vertices(), sequence.surfaces[2].faces()};
  far.vertices.rowwise() += Eigen::RowVector3d(500, 0, 0);
  sequence.surfaces[2] = ClosedSurface(far.vertices, far.faces, "far away");
  const FollowedMotion followed = sequence.follow(timeOrder(4, 0));
  EXPECT_TRUE(followed.layers[1]);
  EXPECT_FALSE(followed.layers[2]);
  ASSERT_TRUE(followed.layers[3]);
  EXPECT_LT(
      (followed.layers[3]->transferred.map.positions() - sequence.maps[3]).rowwise().norm().mean(),
      0.03);
}

TEST(MotionPropagation, FitsAllOfAChainAtOnceWhereAPriorIsLearnt) {
  const Contraction sequence(12);
  const auto smoothed = [&](const PropagationTree& tree, const std::optional<Arc>& closing = {}) {
    return sequence.follow(tree, closing).smoothed;
  };
  EXPECT_EQ(smoothed(timeOrder(12, 2)), 11);
  if (test::underSanitizer()) return;  // the code of the others is met in the tests beside this
  EXPECT_EQ(smoothed(timeOrder(12, 0)), 11);
  EXPECT_EQ(smoothed(cyclicTimeOrder(12, 0), closingArc(12, 0)), 11);
  EXPECT_EQ(smoothed(star(12, 0)), 0);
  EXPECT_EQ(sequence.follow(timeOrder(12, 0), {}, false).smoothed, 0);
  EXPECT_EQ(Contraction(11).follow(timeOrder(11, 0)).smoothed, 0);
}

TEST(MotionPropagation, AveragesBothWaysRoundACycle) {
  const Contraction sequence(12);
  const PropagationTree tree = cyclicTimeOrder(12, 0);
  const FollowedMotion open = sequence.follow(tree, {}, false),
                       closed = sequence.follow(tree, closingArc(12, 0), false),
                       atOnce = sequence.follow(tree, closingArc(12, 0));
  EXPECT_FALSE(open.closing);
  ASSERT_TRUE(closed.closing);
  EXPECT_EQ(closed.closing->brought.positions(),
            open.layers[7]->transferred.map.positions());  // nothing averaged
  ASSERT_TRUE(atOnce.closing);
  EXPECT_EQ(atOnce.closing->carried.positions(), closed.closing->carried.positions());
  EXPECT_EQ(atOnce.closing->brought.positions(), closed.closing->brought.positions());
  EXPECT_GT(closed.averaged, 0);
  EXPECT_EQ(closed.smoothed, 0);
  for (int t = 1; t < 12; ++t) {
    ASSERT_TRUE(closed.layers[t]) << t;
    const Points& found = closed.layers[t]->transferred.map.positions();
    EXPECT_LT((found - sequence.maps[t]).rowwise().norm().mean(), 0.03) << t;
    EXPECT_NE(found, open.layers[t]->transferred.map.positions());
  }
}

TEST(MotionPropagation, ALayerThatIsLostInACycleSpoilsNoOther) {
  for (const size_t lost : {2, 3, 4}) {  // 3 and 4 are the ends of the branches 0 1 2 3 and 0 5 4
    if (lost != 3 && test::underSanitizer()) continue;
    Contraction sequence(6);
    test::Mesh far{sequence.surfaces[lost].vertices(), sequence.surfaces[lost].faces()};
    far.vertices.rowwise() += Eigen::RowVector3d(500, 0, 0);
    sequence.surfaces[lost] = ClosedSurface(far.vertices, far.faces, "far away");
    const FollowedMotion closed = sequence.follow(cyclicTimeOrder(6, 0), closingArc(6, 0));
    EXPECT_FALSE(closed.layers[lost]);
    EXPECT_EQ(closed.averaged, 4);
    for (size_t t = 1; t < 6; ++t) {
      if (t == lost) continue;
      ASSERT_TRUE(closed.layers[t]) << t;
      const Points& found = closed.layers[t]->transferred.map.positions();
      EXPECT_LT((found - sequence.maps[t]).rowwise().norm().mean(), 0.03) << t;
    }
  }
}

TEST(MotionPropagation, ACycleIsTheSameWithAnyNumberOfThreads) {
  const Contraction sequence(12);
  const PropagationTree tree = cyclicTimeOrder(12, 0);
  ThreadPool one(1), several(3);
  const MappedSurface rootMap(sequence.surfaces[0], sequence.maps[0]);
  const FollowedMotion b =
      followMotion(sequence.surfaces, rootMap, tree, several, {}, closingArc(12, 0));
  EXPECT_EQ(b.smoothed, 11);
  if (test::underSanitizer()) return;  // a second run meets what the first did
  const FollowedMotion a =
      followMotion(sequence.surfaces, rootMap, tree, one, {}, closingArc(12, 0));
  for (int t = 1; t < 12; ++t)
    EXPECT_EQ(a.layers[t]->transferred.map.positions(), b.layers[t]->transferred.map.positions());
  EXPECT_EQ(a.closing->carried.positions(), b.closing->carried.positions());
}

}  // namespace
}  // namespace sphere_propagation
