// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/thin_svd.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>

#include "tests/core/test_meshes.h"

namespace sphere_propagation {
namespace {

using Dense = Eigen::MatrixXd;

Dense orthonormal(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  test::Random random(seed);
  Dense matrix(rows, columns);
  for (Eigen::Index i = 0; i < matrix.size(); ++i) matrix.data()[i] = random.normal();
  return Eigen::HouseholderQR<Dense>(matrix).householderQ() * Dense::Identity(rows, columns);
}

double fromIdentity(const Dense& vectors) {
  return (vectors.transpose() * vectors - Dense::Identity(vectors.cols(), vectors.cols()))
      .cwiseAbs()
      .maxCoeff();
}

TEST(ThinSvd, FindsSmallSingularValuesBesideLargeOnes) {
  // From 1 to 1e-8, whose squares are lost beside 1 in one Gram matrix; wide and tall.
  Eigen::VectorXd s(40);
  for (int i = 0; i < 40; ++i) s[i] = std::pow(10, -i / 5.0);
  const Dense tall = orthonormal(300, 40, 1) * s.asDiagonal() * orthonormal(40, 40, 2).transpose();
  ThreadPool pool(2);
  for (const Dense& matrix : {tall, Dense(tall.transpose())}) {
    const ThinSvd svd = thinSvd(matrix, 1e-12, 1000, pool);
    ASSERT_EQ(svd.s.size(), 40);
    EXPECT_LT((svd.s - s).cwiseQuotient(s).cwiseAbs().head(30).maxCoeff(), 1e-9);  // to 1e-6
    EXPECT_LT((svd.s - s).cwiseQuotient(s).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_LT(fromIdentity(svd.u), 1e-12);
    EXPECT_LT(fromIdentity(svd.v), 1e-12);
    EXPECT_LT((svd.u * svd.s.asDiagonal() * svd.v.transpose() - matrix).cwiseAbs().maxCoeff(),
              1e-14);
  }
}

TEST(ThinSvd, LeavesOutWhatRoundingExplains) {
  Eigen::VectorXd s(6);
  s << 5, 4, 3, 1e-3, 1e-7, 1e-9;
  const Dense matrix = orthonormal(50, 6, 3) * s.asDiagonal() * orthonormal(6, 6, 4).transpose();
  ThreadPool pool;
  EXPECT_EQ(thinSvd(matrix, 1e-8, 6, pool).s.size(), 5);
  EXPECT_EQ(thinSvd(matrix, 1e-4, 6, pool).s.size(), 4);
  EXPECT_EQ(thinSvd(matrix, 10, 6, pool).s.size(), 0);
  EXPECT_EQ(thinSvd(Dense::Zero(50, 6), 0, 6, pool).s.size(), 0);
}

TEST(ThinSvd, ComputesTheLeftVectorsThatAreAskedFor) {
  const Dense matrix = orthonormal(50, 6, 5) * Eigen::VectorXd::LinSpaced(6, 6, 1).asDiagonal();
  ThreadPool pool;
  const ThinSvd all = thinSvd(matrix, 1e-10, 6, pool), two = thinSvd(matrix, 1e-10, 2, pool);
  ASSERT_EQ(two.u.cols(), 2);
  EXPECT_LT((two.u - all.u.leftCols(2)).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_EQ(two.v, all.v);
}

}  // namespace
}  // namespace sphere_propagation
