// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/dense_cholesky.h"

#include <gtest/gtest.h>

namespace sphere_propagation {
namespace {

// L L^T with L = (2 0; 1 3).
const Eigen::MatrixXd ofTwo = (Eigen::MatrixXd(2, 2) << 4, 2, 2, 10).finished();

TEST(DenseCholesky, SolvesByHand) {
  const DenseCholesky factor(ofTwo);
  ASSERT_TRUE(factor.succeeded());
  EXPECT_TRUE(
      factor.solve(Eigen::VectorXd(Eigen::Vector2d(8, 22))).isApprox(Eigen::Vector2d(1, 2)));
  EXPECT_TRUE(factor.solve(ofTwo).isIdentity(1e-12));
  EXPECT_TRUE(
      factor.solveLower(Eigen::MatrixXd(Eigen::Vector2d(2, 7))).isApprox(Eigen::Vector2d(1, 2)));
  EXPECT_TRUE(
      factor.solveUpper(Eigen::MatrixXd(Eigen::Vector2d(4, 6))).isApprox(Eigen::Vector2d(1, 2)));
}

TEST(DenseCholesky, ReadsTheLowerTriangle) {
  Eigen::MatrixXd lower = ofTwo;
  lower(0, 1) = 1e9;
  EXPECT_TRUE(DenseCholesky(lower).solve(ofTwo).isIdentity(1e-12));
  EXPECT_TRUE(solveSymmetric(lower, Eigen::Vector2d(8, 22)).isApprox(Eigen::Vector2d(1, 2)));
}

TEST(DenseCholesky, SaysWhereAMatrixIsNotPositiveDefinite) {
  EXPECT_FALSE(DenseCholesky(Eigen::MatrixXd(-ofTwo)).succeeded());
  EXPECT_FALSE(DenseCholesky().succeeded());
}

TEST(DenseCholesky, SolvesWhatIsSemidefinite) {
  const Eigen::MatrixXd flat = Eigen::Vector3d(2, 0, 3).asDiagonal();
  EXPECT_TRUE(solveSymmetric(flat, Eigen::Vector3d(2, 0, 6)).isApprox(Eigen::Vector3d(1, 0, 2)));
}

}  // namespace
}  // namespace sphere_propagation
