// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_cycle.h"

#include <gtest/gtest.h>

#include "tests/core/test_meshes.h"
#include "vcg_ext/mesh/surface_locator.h"

namespace sphere_propagation {
namespace {

constexpr int layers = 6;

/// An ellipsoid that breathes once, on a mesh of its own for each phase.
struct Beat {
  std::vector<ClosedSurface> surfaces;
  Points rootMap;
  PropagationTree tree = cyclicTimeOrder(layers, 0);
  ClosedCycle cycle = closedCycle(tree, closingArc(layers, 0));
  Beat() {
    for (int i = 0; i < layers; ++i) {
      test::Mesh mesh = test::transformed(test::icosphereMesh(7 + i % 2),
                                          test::randomRotation(40 + i), 1, Vector3::Zero());
      if (i == 0) rootMap = mesh.vertices;
      const double size = 1 - 0.3 * std::sin(3.14159265358979323846 * i / layers);
      mesh.vertices *= (size * Vector3(40, 28, 20)).asDiagonal();
      surfaces.emplace_back(mesh.vertices, mesh.faces, "phase " + std::to_string(i));
    }
  }
  MotionModel model() const { return MotionModel(MappedSurface(surfaces[0], rootMap)); }
};

std::vector<Eigen::VectorXd> translations(double byLayer) {
  std::vector<Eigen::VectorXd> coefficients(layers, Eigen::VectorXd::Zero(MotionBasis::columns));
  for (int i = 0; i < layers; ++i)
    coefficients[static_cast<size_t>(i)][MotionBasis::localColumns] = byLayer * i;
  return coefficients;
}

TEST(MotionCycle, SharesGoFromThreeQuartersToOneAndAddUp) {
  EXPECT_DOUBLE_EQ(forwardShare(5, 10), 0.5);
  for (int step = 1; step < 10; ++step) {
    EXPECT_DOUBLE_EQ(forwardShare(step, 10), (0.5 + (10 - step) / 10.0) / 2);
    EXPECT_DOUBLE_EQ(forwardShare(step, 10) + forwardShare(10 - step, 10), 1);
  }
}

TEST(MotionCycle, WaysThatAgreeAreWhatTheTreeBrings) {
  const Beat beat;
  ThreadPool pool;
  const Sequence targets(beat.surfaces);
  const std::vector<Eigen::VectorXd> brought = translations(1.0 / 3);
  EXPECT_EQ(averageOfBothWays(beat.model(), targets, beat.cycle, brought, brought), brought);
}

TEST(MotionCycle, AveragesByTheStepsFromTheRoot) {
  const Beat beat;
  ThreadPool pool;
  const Sequence targets(beat.surfaces);
  const std::vector<Eigen::VectorXd> average =
      averageOfBothWays(beat.model(), targets, beat.cycle, translations(1), translations(2));
  for (int step = 0; step < layers; ++step) {
    const double own = step <= 3 ? forwardShare(step, layers) : 1 - forwardShare(step, layers);
    EXPECT_NEAR(average[static_cast<size_t>(step)][MotionBasis::localColumns],
                step * (own + 2 * (1 - own)), 1e-12);
  }
}

TEST(MotionCycle, KeepsWhatTheTreeBringsWhereTheOtherWayIsLost) {
  const Beat beat;
  ThreadPool pool;
  const Sequence targets(beat.surfaces);
  const std::vector<Eigen::VectorXd> brought = translations(1);
  std::vector<Eigen::VectorXd> around = brought;
  around[2][MotionBasis::localColumns] += 2.01 * targets[2].meanEdge();
  around[3][MotionBasis::localColumns] += 1.99 * targets[3].meanEdge();
  around[4].setConstant(std::numeric_limits<double>::quiet_NaN());
  const std::vector<Eigen::VectorXd> average =
      averageOfBothWays(beat.model(), targets, beat.cycle, brought, around);
  EXPECT_EQ(average[2], brought[2]);
  EXPECT_NE(average[3], brought[3]);
  EXPECT_EQ(average[4], brought[4]);
}

TEST(MotionCycle, TheOtherWayRoundLeadsToEveryLayer) {
  const Beat beat;
  const MotionModel model = beat.model();
  ThreadPool pool(2);
  const Sequence targets(beat.surfaces);
  const MotionFit fit = fitMotion(model, targets, beat.tree, fixedMotionPrior(), pool);
  const std::vector<Eigen::VectorXd> around =
      fitOtherWayRound(model, targets, beat.cycle, fit, fixedMotionPrior(), pool);
  EXPECT_EQ(around[0].norm(), 0);
  for (size_t t = 1; t < layers; ++t) {
    const Points moved = model.movedNodes(around[t]);
    double sum = 0;
    for (Eigen::Index i = 0; i < moved.rows(); ++i)
      sum += targets[static_cast<int>(t)].locator().closest(moved.row(i).transpose()).distance;
    EXPECT_LT(sum / static_cast<double>(moved.rows()), 0.3) << t;  // of a radius of 28
    EXPECT_NE(around[t], fit.coefficients[t]);
  }
  // The arcs are those of the cycle: one step beyond where the branches meet, from what they bring
  // there.
  const auto beyond = [&](size_t from, size_t to) {
    return fitArcAgain(model, targets[to], fit.coefficients[from], fixedMotionPrior(),
                       fit.coefficients[to] - fit.coefficients[from],
                       {fit.equations[to].matrix, fit.factors[to]});
  };
  EXPECT_EQ(around[4], beyond(3, 4));
  EXPECT_EQ(around[3], beyond(4, 3));
}

TEST(MotionCycle, IsTheSameWithAnyNumberOfThreads) {
  const Beat beat;
  const MotionModel model = beat.model();
  ThreadPool one(1), several(3);
  const Sequence targets(beat.surfaces);
  const MotionFit fit = fitMotion(model, targets, beat.tree, fixedMotionPrior(), one);
  EXPECT_EQ(fitOtherWayRound(model, targets, beat.cycle, fit, fixedMotionPrior(), one),
            fitOtherWayRound(model, targets, beat.cycle, fit, fixedMotionPrior(), several));
}

}  // namespace
}  // namespace sphere_propagation
