// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/dense_kernels.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "tests/core/test_meshes.h"

namespace sphere_propagation {
namespace {

RowsF randomRows(Eigen::Index count, Eigen::Index columns, unsigned seed) {
  test::Random random(seed);
  RowsF rows(count, columns);
  for (Eigen::Index i = 0; i < rows.size(); ++i)
    rows.data()[i] = static_cast<float>(random.normal());
  return rows;
}

TEST(DenseKernels, SumsOuterProducts) {
  for (Eigen::Index count : {0, 1, 5, 64, 65, 200})
    for (Eigen::Index columns : {1, 5, 6, 16, 17, 48, 252}) {
      const RowsF rows = randomRows(count, columns, static_cast<unsigned>(count + columns));
      const Eigen::MatrixXd expected = rows.cast<double>().transpose() * rows.cast<double>();
      const Eigen::MatrixXf sum = sumOfOuterProducts(rows);
      EXPECT_EQ(sum, sum.transpose());
      EXPECT_LT((sum.cast<double>() - expected).norm(), 1e-5 * (1 + expected.norm()))
          << count << " " << columns;
    }
}

TEST(DenseKernels, NumbersWhoseProductsAreDenormalAreZeros) {
  RowsF rows = randomRows(70, 30, 1);
  rows.col(3) *= 1e-25F;
  rows(5, 7) = -1e-22F;
  const Eigen::MatrixXf sum = sumOfOuterProducts(rows);
  rows.col(3).setZero();
  rows(5, 7) = 0;
  EXPECT_EQ(sum, sumOfOuterProducts(rows));
  EXPECT_EQ(sum(3, 3), 0);
  RowsF small = RowsF::Zero(1, 2);
  small << 2e-19F, 1e-3F;  // not tiny
  EXPECT_GT(sumOfOuterProducts(small)(1, 0), 0);
  rows(0, 0) = std::nanf("");
  EXPECT_TRUE(std::isnan(sumOfOuterProducts(rows)(0, 0)));
}

Points unitVectors(Eigen::Index count, unsigned seed) {
  test::Random random(seed);
  Points points(count, 3);
  for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] = random.normal();
  return points.rowwise().normalized();
}

TEST(DenseKernels, SumsKernels) {
  const Points centres = unitVectors(50, 1), vectors = unitVectors(50, 2);
  for (const double sharpness : {0.0, 1.0, 7.3, 350.0})
    for (const Eigen::Index count : {0, 1, 31, 32, 33, 100}) {
      Points points = unitVectors(count, 3);
      if (count > 2) points.row(1) = centres.row(4), points.row(2) = -centres.row(5);
      const Points sums = kernelSums(points, centres, vectors, sharpness);
      ASSERT_EQ(sums.rows(), count);
      for (Eigen::Index i = 0; i < count; ++i) {
        Eigen::RowVector3d expected = Eigen::RowVector3d::Zero();
        double size = 0;
        for (Eigen::Index q = 0; q < centres.rows(); ++q) {
          const double kernel = std::exp(sharpness * (points.row(i).dot(centres.row(q)) - 1));
          expected += kernel * vectors.row(q);
          size += kernel;
        }
        // The argument is known to sharpness epsilon.
        EXPECT_LT((sums.row(i) - expected).norm(), (1 + sharpness) * 1e-15 * size)
            << sharpness << " " << i;
      }
    }
}

TEST(DenseKernels, SumsKernelsInTheOrderOfTheCentres) {
  const Points points = unitVectors(40, 4), centres = unitVectors(9, 5),
               vectors = unitVectors(9, 6);
  Points expected = Points::Zero(40, 3);
  for (Eigen::Index q = 0; q < 9; ++q) {
    const Points kernels = kernelSums(points, centres.row(q), Points::Ones(1, 3), 4);
    for (Eigen::Index i = 0; i < 40; ++i)
      for (int k = 0; k < 3; ++k) {
        const volatile double product = kernels(i, k) * vectors(q, k);  // not fused with the sum
        expected(i, k) += product;
      }
  }
  EXPECT_EQ(kernelSums(points, centres, vectors, 4), expected);
}

TEST(DenseKernels, SumsInTheOrderOfTheRows) {
  // So that every processor rounds in the same way.
  const RowsF rows = randomRows(150, 20, 3);
  Eigen::MatrixXf expected = Eigen::MatrixXf::Zero(20, 20);
  for (Eigen::Index k = 0; k < rows.rows(); ++k)
    for (Eigen::Index i = 0; i < 20; ++i)
      for (Eigen::Index j = 0; j < 20; ++j) {
        const volatile float product = rows(k, i) * rows(k, j);  // not fused with the sum
        expected(i, j) += product;
      }
  EXPECT_EQ(sumOfOuterProducts(rows), expected);
}

TEST(DenseKernels, InvertsPositiveDefiniteMatrices) {
  for (Eigen::Index size : {1, 2, 11, 12, 13, 40, 252}) {
    const Eigen::MatrixXd rows =
        randomRows(size + 3, size, static_cast<unsigned>(size)).cast<double>();
    const Eigen::MatrixXd matrix =
        rows.transpose() * rows + 1e-3 * Eigen::MatrixXd::Identity(size, size);
    Eigen::MatrixXd lower = matrix;
    lower.triangularView<Eigen::StrictlyUpper>().setConstant(1e9);  // not looked at
    const Eigen::MatrixXd inverse = inverseOf(lower);
    EXPECT_EQ(inverse, inverse.transpose());
    EXPECT_LT((inverse * matrix - Eigen::MatrixXd::Identity(size, size)).norm(), 1e-8) << size;
  }
}

}  // namespace
}  // namespace sphere_propagation
