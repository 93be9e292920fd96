// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/conjugate_gradients.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "tests/core/test_meshes.h"

namespace sphere_propagation {
namespace {

using Dense = Eigen::MatrixXd;

Dense randomOf(Eigen::Index rows, Eigen::Index columns, test::Random& random) {
  return Dense::NullaryExpr(rows, columns, [&] { return random.normal(); });
}

struct System {
  Dense matrix, inverse;  // of its diagonal
  explicit System(Eigen::Index size) {
    test::Random random(3);
    const Dense rows = randomOf(size, size, random);
    matrix = rows * rows.transpose();
    matrix.diagonal().array() += 1;
    inverse = matrix.diagonal().cwiseInverse().asDiagonal();
  }
};

TEST(ConjugateGradients, SolveInAsManyStepsAsThereAreUnknowns) {
  const System system(12);
  test::Random random(4);
  const Eigen::VectorXd right = randomOf(12, 1, random);
  Eigen::VectorXd x = randomOf(12, 1, random);
  const int steps = solveByConjugateGradients(
      [&](const Eigen::VectorXd& v) { return system.matrix * v; },
      [&](const Eigen::VectorXd& v) { return system.inverse * v; }, right, x, {1e-24, 100});
  EXPECT_LE(steps, 20);  // 12, but for rounding
  EXPECT_LT((system.matrix * x - right).norm(), 1e-10 * right.norm());
}

TEST(ConjugateGradients, TakeAMatrixForAVectorAndAnExactPreconditionerAtItsWord) {
  const System system(9);
  test::Random random(5);
  const Dense right = randomOf(9, 4, random);
  const Eigen::LLT<Dense> exact(system.matrix);
  Dense x = Dense::Zero(9, 4);
  const int steps = solveByConjugateGradients(
      [&](const Dense& v) -> Dense { return system.matrix * v; },
      [&](const Dense& v) -> Dense { return exact.solve(v); }, right, x, {1e-20, 100});
  EXPECT_LE(steps, 2);
  EXPECT_LT((x - exact.solve(right)).norm(), 1e-10 * x.norm());
}

TEST(ConjugateGradients, StopWhereTheyStartNearEnoughOrMayGoNoFurther) {
  const System system(12);
  test::Random random(6);
  const Eigen::VectorXd right = randomOf(12, 1, random);
  const auto times = [&](const Eigen::VectorXd& v) { return system.matrix * v; };
  const auto precondition = [&](const Eigen::VectorXd& v) { return system.inverse * v; };
  const Eigen::VectorXd solution = system.matrix.llt().solve(right);
  Eigen::VectorXd x = solution;
  EXPECT_EQ(solveByConjugateGradients(times, precondition, right, x, {1e-6, 100}), 0);
  EXPECT_EQ(x, solution);
  x.setZero();
  EXPECT_EQ(solveByConjugateGradients(times, precondition, right, x, {1e-30, 3}), 3);
}

TEST(ConjugateGradients, OfNothingIsNothing) {
  const System system(5);
  const Eigen::VectorXd right = Eigen::VectorXd::Zero(5);
  Eigen::VectorXd x = right;
  EXPECT_EQ(solveByConjugateGradients([&](const Eigen::VectorXd& v) { return system.matrix * v; },
                                      [&](const Eigen::VectorXd& v) { return system.inverse * v; },
                                      right, x, {}),
            0);
  EXPECT_EQ(x, right);
}

}  // namespace
}  // namespace sphere_propagation
