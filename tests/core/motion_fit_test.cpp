// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/core/test_meshes.h"
#include "tests/core/test_pool.h"
#include "vcg_ext/propagation/motion/motion_learning.h"

namespace sphere_propagation {
namespace {

using test::pool;

/// An ellipsoid on a mesh of its own for each phase, moved as a whole by `shift` per phase.
struct BreathingPhases {
  std::vector<ClosedSurface> surfaces;
  Points rootMap;
  BreathingPhases(int layers, const Vector3& shift, double breathing) {
    for (int i = 0; i < layers; ++i) {
      test::Mesh mesh = test::transformed(test::icosphereMesh(7 + i % 2),
                                          test::randomRotation(40 + i), 1, Vector3::Zero());
      if (i == 0) rootMap = mesh.vertices;
      const double size = 1 - breathing * std::sin(3.14159265358979323846 * i / layers);
      mesh.vertices *= (size * Vector3(40, 28, 20)).asDiagonal();
      mesh.vertices.rowwise() += (i * shift).transpose();
      surfaces.emplace_back(mesh.vertices, mesh.faces, "phase " + std::to_string(i));
    }
  }
  MotionModel model() const { return MotionModel(MappedSurface(surfaces[0], rootMap)); }
};

TEST(MotionFit, RecoversATranslation) {
  const BreathingPhases sequence(2, Vector3(2, -1, 1), 0);
  const MotionModel model = sequence.model();
  MotionVariances variances{1e-6, 10, 1e-6, 1e-6};
  const MotionFit fit = fitMotion(model, sequence.surfaces, star(2, 0),
                                  {variances.diagonal().cwiseInverse().asDiagonal(), 6}, pool);
  EXPECT_EQ(fit.coefficients[0].norm(), 0);
  const Vector3 found = fit.coefficients[1].segment<3>(MotionBasis::localColumns);
  EXPECT_LT((found - Vector3(2, -1, 1)).norm(), 0.1);
}

TEST(MotionFit, MovesTheSurfaceOntoTheLayer) {
  const BreathingPhases sequence(6, Vector3(1, 0, 0), 0.3);
  const MotionModel model = sequence.model();
  const MotionFit fit =
      fitMotion(model, sequence.surfaces, timeOrder(6, 0), fixedMotionPrior(), pool);
  EXPECT_EQ(fit.lost, std::vector<char>(6, 0));
  for (int t = 1; t < 6; ++t) {
    const SurfaceLocator locator(sequence.surfaces[t].vertices(), sequence.surfaces[t].faces());
    const Points moved = model.movedNodes(fit.coefficients[t]);
    double sum = 0;
    for (Eigen::Index i = 0; i < moved.rows(); ++i)
      sum += locator.closest(moved.row(i).transpose()).distance;
    EXPECT_LT(sum / static_cast<double>(moved.rows()), 0.3) << t;  // of a radius of 28
  }
}

TEST(MotionFit, SaysWhichLayersItLoses) {
  BreathingPhases sequence(4, Vector3::Zero(), 0.1);
  Points far = sequence.surfaces[2].vertices();
  far.rowwise() += Eigen::RowVector3d(500, 0, 0);
  sequence.surfaces[2] = ClosedSurface(far, sequence.surfaces[2].faces(), "far away");
  const MotionModel model = sequence.model();
  const Sequence targets(sequence.surfaces);
  const MotionFit fit = fitMotion(model, targets, timeOrder(4, 0), fixedMotionPrior(), pool);
  EXPECT_EQ(fit.lost, (std::vector<char>{0, 0, 1, 0}));
  // What lies behind comes from the one before.
  EXPECT_EQ(fit.coefficients[3],
            fitArc(model, targets[3], fit.coefficients[1], fixedMotionPrior()).coefficients);
}

TEST(MotionFit, EquationsAreThoseOfTheLastIteration) {
  const BreathingPhases sequence(2, Vector3(0, 0, 0), 0.2);
  const MotionModel model = sequence.model();
  const MotionPrior prior = fixedMotionPrior();
  const MotionFit fit = fitMotion(model, sequence.surfaces, star(2, 0), prior, pool);
  const ArcEquations& e = fit.equations[1];
  EXPECT_LT((e.matrix - e.matrix.transpose()).norm(), 1e-9 * e.matrix.norm());
  EXPECT_LT(((e.matrix + prior.precision) * fit.coefficients[1] - e.vector).norm(),
            1e-8 * e.vector.norm());
  EXPECT_EQ(fit.equations[0].vector.size(), 0);
}

TEST(MotionFit, AnEarlierFitSavesAnIteration) {
  const BreathingPhases sequence(3, Vector3(1, 0, 0), 0.2);
  const MotionModel model = sequence.model();
  const Sequence targets(sequence.surfaces);
  const MotionPrior prior = fixedMotionPrior();
  const MotionFit first = fitMotion(model, targets, timeOrder(3, 0), prior, pool);
  const MotionFit again =
      refitMotion(model, targets, timeOrder(3, 0), prior, first.coefficients, pool);
  for (size_t t = 1; t < 3; ++t) {
    const Eigen::VectorXd& before = first.coefficients[t - 1];
    const Eigen::VectorXd step = first.coefficients[t] - before;
    EXPECT_LT((again.coefficients[t] - first.coefficients[t]).norm(), 0.1 * step.norm());
    EXPECT_EQ(fitArc(model, targets[t], before, prior).coefficients, first.coefficients[t]);
    EXPECT_NE(again.coefficients[t], first.coefficients[t]);
    const Eigen::VectorXd once = fitArcAgain(model, targets[t], before, prior, step,
                                             {first.equations[t].matrix, first.factors[t]});
    EXPECT_LT((once - first.coefficients[t]).norm(), 0.1 * step.norm());
  }
}

TEST(MotionFit, KeepsTheFactorOfItsSystem) {
  const BreathingPhases sequence(2, Vector3(1, 0, 0), 0.2);
  const MotionPrior prior = fixedMotionPrior();
  const MotionFit fit = fitMotion(sequence.model(), sequence.surfaces, star(2, 0), prior, pool);
  const Eigen::MatrixXd system = fit.equations[1].matrix + prior.precision;
  const auto one = Eigen::MatrixXd::Identity(system.rows(), system.cols());
  EXPECT_LT((fit.factors[1].solve(system) - one).norm(), 1e-9);
}

TEST(MotionPrior, TheFixedOneIsDiagonal) {
  const MotionPrior prior = fixedMotionPrior();
  EXPECT_EQ(prior.precision(0, 0), 1);
  EXPECT_EQ(prior.precision(MotionBasis::localColumns, MotionBasis::localColumns), 2);
  EXPECT_EQ(prior.precision.diagonal().asDiagonal().toDenseMatrix(), prior.precision);
}

TEST(MotionPrior, LearnsThatASequenceTravels) {
  const BreathingPhases staying(14, Vector3::Zero(), 0.25), travelling(14, Vector3(2, 1, 0), 0.25);
  const auto learnt = [](const BreathingPhases& sequence) {
    return learnMotionPrior(sequence.model(), sequence.surfaces, cyclicTimeOrder(14, 0), pool);
  };
  const LearntPrior still = learnt(staying), moved = learnt(travelling);
  EXPECT_GT(moved.variances.translation, 5 * still.variances.translation);
  const Eigen::LLT<Eigen::MatrixXd> factor(still.prior.precision);
  EXPECT_EQ(factor.info(), Eigen::Success);  // positive definite
}

}  // namespace
}  // namespace sphere_propagation
