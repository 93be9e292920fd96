// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/leave_one_out.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/core/test_shapes.h"
#include "vcg_ext/model/shape_model.h"

namespace sphere_propagation {
namespace {

using Dense = Eigen::MatrixXd;

/// Scores of count shapes in a space of so many dimensions, whose extents fall by a factor.
Dense scoresOf(int count, int dimensions, double factor, unsigned seed) {
  test::Random random(seed);
  Dense shapes(count, dimensions);
  for (Eigen::Index i = 0; i < shapes.size(); ++i)
    shapes.data()[i] = random.normal() * std::pow(factor, static_cast<double>(i / count));
  return shapes;
}

Dense inTheirAxes(Dense shapes) {
  shapes.rowwise() -= Eigen::RowVectorXd(shapes.colwise().mean());
  const Eigen::JacobiSVD<Dense> svd(shapes, Eigen::ComputeThinU | Eigen::ComputeThinV);
  Eigen::Index count = 0;
  while (count < svd.singularValues().size() &&
         svd.singularValues()[count] > 1e-13 * svd.singularValues()[0])
    ++count;
  return svd.matrixU().leftCols(count) * svd.singularValues().head(count).asDiagonal();
}

/// By the definition: what the modes of the others leave of the shape, one after the other; a row
/// for each number of modes.
Dense restsByDefinition(const Dense& scores, Eigen::Index left) {
  const Eigen::Index others = scores.rows() - 1, modes = scores.cols();
  Dense rests(modes, scores.cols());
  Dense rest(others, scores.cols());
  rest << scores.topRows(left), scores.bottomRows(others - left);
  const Eigen::RowVectorXd mean = rest.colwise().mean();
  rest.rowwise() -= mean;
  const Eigen::JacobiSVD<Dense> svd(rest, Eigen::ComputeThinV);
  const double rounding =
      static_cast<double>(scores.rows()) * std::numeric_limits<double>::epsilon() * scores.norm();
  Eigen::VectorXd residual = (scores.row(left) - mean).transpose();
  for (Eigen::Index m = 0; m < modes; ++m) {
    if (m < std::min(svd.singularValues().size(), others - 1) && svd.singularValues()[m] > rounding)
      residual -= svd.matrixV().col(m) * svd.matrixV().col(m).dot(residual);
    rests.row(m) = residual.transpose();
  }
  return rests;
}

Eigen::VectorXd byDefinition(const Dense& scores, Eigen::Index left) {
  return restsByDefinition(scores, left).rowwise().norm();
}

/// Where two modes of the others are nearly equally large, either may come first.
void expectApproximations(const Dense& scores, Eigen::Index left) {
  const Dense rests =
      -(leftOutApproximations(scores, left, scores.cols()).rowwise() - scores.row(left));
  EXPECT_LT((rests - restsByDefinition(scores, left)).cwiseAbs().maxCoeff(),
            1e-7 * scores.rowwise().norm().maxCoeff());
}

void expectDefinition(const Dense& scores, Eigen::Index step = 1) {
  ThreadPool pool;
  const Dense found = leaveOneOut(scores, scores.cols(), pool);
  ASSERT_EQ(found.rows(), scores.rows());
  for (Eigen::Index left = 0; left < scores.rows(); left += step) {
    SCOPED_TRACE(left);
    EXPECT_LT((found.row(left).transpose() - byDefinition(scores, left)).cwiseAbs().maxCoeff(),
              1e-10 * scores.rowwise().norm().maxCoeff());
    expectApproximations(scores, left);
  }
}

TEST(LeaveOneOut, IsItsDefinition) {
  for (const int shapes : {2, 3, 4, 5, 12, 30}) {
    SCOPED_TRACE(shapes);
    expectDefinition(inTheirAxes(scoresOf(shapes, 60, 1, 1)));    // fewer shapes than coordinates
    expectDefinition(inTheirAxes(scoresOf(shapes, 60, 0.8, 2)));  // modes of very different sizes
    expectDefinition(inTheirAxes(scoresOf(shapes, 9, 1, 3)));     // and more of them
    expectDefinition(inTheirAxes(scoresOf(shapes, 1, 1, 4)));
  }
}

TEST(LeaveOneOut, IsItsDefinitionWithManyModes) {
  expectDefinition(inTheirAxes(scoresOf(120, 200, 1, 5)), 30);
  expectDefinition(inTheirAxes(scoresOf(120, 200, 0.97, 6)), 30);
}

TEST(LeaveOneOut, IsItsDefinitionForDuplicates) {
  Dense shapes = scoresOf(9, 20, 0.9, 7);
  shapes.row(5) = shapes.row(2);  // all others are not in the span of the rest
  expectDefinition(inTheirAxes(shapes));
  Dense twice(18, 20);
  twice << shapes, shapes;
  expectDefinition(inTheirAxes(twice));
  Dense near(18, 20);  // two of each but for a ten thousandth
  near << shapes, shapes + 1e-4 * scoresOf(9, 20, 1, 8);
  expectDefinition(inTheirAxes(near));
}

TEST(LeaveOneOut, IsItsDefinitionForEqualEigenvalues) {
  // Corners of a cross: d_1 = d_2 = d_3, most scores 0.
  Dense cross = Dense::Zero(6, 3);
  for (int axis = 0; axis < 3; ++axis) {
    cross(2 * axis, axis) = 1;
    cross(2 * axis + 1, axis) = -1;
  }
  expectDefinition(cross);
}

TEST(LeaveOneOut, AShapeBeyondTheSpanOfTheOthersStaysThere) {
  // Nine shapes in a plane, one above it at height 4: no mode of the others brings it closer.
  Dense shapes = Dense::Zero(10, 3);
  shapes.leftCols(2) = scoresOf(10, 2, 1, 9);
  shapes(3, 2) = 4;
  ThreadPool pool;
  EXPECT_NEAR(leaveOneOut(inTheirAxes(shapes), 3, pool)(3, 2), 4, 1e-12);
}

TEST(LeaveOneOut, FewModesAreTheFirstOfMany) {
  ThreadPool pool;
  for (const double factor : {1.0, 0.5}) {  // a rest that is large, and one that is small
    const Dense scores = inTheirAxes(scoresOf(40, 80, factor, 10));
    const Dense all = leaveOneOut(scores, scores.cols(), pool);
    for (const Eigen::Index modes : {1, 3, 15})
      EXPECT_LT((leaveOneOut(scores, modes, pool) - all.leftCols(modes)).cwiseAbs().maxCoeff(),
                1e-13 * all.maxCoeff());
  }
}

TEST(LeaveOneOut, IsTheSameWithAnyNumberOfThreads) {
  const Dense scores = inTheirAxes(scoresOf(100, 120, 0.98, 11));
  ThreadPool one(1), three(3);
  std::vector<double> progress;
  const Dense alone =
      leaveOneOut(scores, scores.cols(), one, [&](double p) { progress.push_back(p); });
  EXPECT_EQ(leaveOneOut(scores, scores.cols(), three), alone);
  EXPECT_GT(progress.size(), 1u);
  EXPECT_TRUE(std::is_sorted(progress.begin(), progress.end()));
  EXPECT_EQ(progress.back(), 1);
}

}  // namespace
}  // namespace sphere_propagation
