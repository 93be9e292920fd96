// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/shape_model.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "tests/core/test_shapes.h"

namespace sphere_propagation {
namespace {

using Eigen::VectorXd;

using test::largestDifference;
using test::modelOf;

TEST(ShapeModel, HasTheEigenvaluesOfTheCovariance) {
  const auto shapes = test::ellipsoids(7, 1);
  const ShapeModel model = modelOf(shapes);
  ASSERT_EQ(model.modeCount(), 6);
  // By the definition: covariance of all 486 coordinates, divisor K - 1.
  Eigen::MatrixXd data(486, 7);
  for (int k = 0; k < 7; ++k)
    data.col(k) = Eigen::Map<const VectorXd>(shapes[static_cast<size_t>(k)].data(), 486);
  data.colwise() -= VectorXd(data.rowwise().mean());
  const Eigen::MatrixXd covariance = data * data.transpose() / 6;
  const VectorXd expected =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(covariance).eigenvalues().reverse();
  EXPECT_LT(
      (model.eigenvalues - expected.head(6)).cwiseQuotient(expected.head(6)).cwiseAbs().maxCoeff(),
      1e-10);
  EXPECT_NEAR(model.totalVariance, covariance.trace(), 1e-9 * covariance.trace());
  EXPECT_LT((covariance * model.modes - model.modes * model.eigenvalues.asDiagonal()).norm(),
            1e-9 * expected[0]);
}

TEST(ShapeModel, ModesAreOrthonormalAndScoresUncorrelated) {
  const ShapeModel model = modelOf(test::ellipsoids(9, 2));
  const auto identity = Eigen::MatrixXd::Identity(8, 8);
  EXPECT_LT((model.modes.transpose() * model.modes - identity).norm(), 1e-12);
  const Eigen::MatrixXd covariance = model.scores.transpose() * model.scores / 8;
  EXPECT_LT((covariance - Eigen::MatrixXd(model.eigenvalues.asDiagonal())).norm(),
            1e-10 * model.eigenvalues[0]);
  EXPECT_LT(model.scores.colwise().sum().norm(), 1e-9);
}

TEST(ShapeModel, RebuildsItsShapes) {
  const auto shapes = test::ellipsoids(6, 3);
  const ShapeModel model = modelOf(shapes);
  for (int k = 0; k < 6; ++k)
    EXPECT_LT(largestDifference(model.shape(VectorXd(model.scores.row(k).transpose())),
                                shapes[static_cast<size_t>(k)]),
              1e-11);
  EXPECT_EQ(model.names[4], "shape 4");
}

TEST(ShapeModel, OneModeInClosedForm) {
  // x_k = mean + c_k u with |u| = 1: one eigenvalue, the variance of c.
  const Points mean = test::ellipsoids(1, 4).front(), u = test::randomDirection(162, 5);
  const std::vector<double> c = {-3, 1, 4, 6};  // mean 2, variance (25 + 1 + 4 + 16) / 3
  std::vector<Points> shapes;
  for (const double amount : c) shapes.push_back(mean + amount * u);
  const ShapeModel model = modelOf(shapes);
  ASSERT_EQ(model.modeCount(), 1);
  EXPECT_NEAR(model.eigenvalues[0], 46.0 / 3, 1e-10);
  EXPECT_LT(largestDifference(model.mean, mean + 2 * u), 1e-12);
  const Points mode = Eigen::Map<const Points>(model.modes.data(), 162, 3);
  const double sign = mode.cwiseProduct(u).sum();
  EXPECT_NEAR(std::fabs(sign), 1, 1e-12);
  for (int k = 0; k < 4; ++k)
    EXPECT_NEAR(sign * model.scores(k, 0), c[static_cast<size_t>(k)] - 2, 1e-10);
  EXPECT_LT(largestDifference(model.shape(0, -3), model.mean - 3 * std::sqrt(46.0 / 3) * mode),
            1e-12);
}

TEST(ShapeModel, SignsFollowTheLargestEntry) {
  auto shapes = test::ellipsoids(6, 6);
  const ShapeModel model = modelOf(shapes);
  for (Eigen::Index m = 0; m < model.modeCount(); ++m) {
    Eigen::Index largest = 0;
    model.modes.col(m).cwiseAbs().maxCoeff(&largest);
    EXPECT_GT(model.modes(largest, m), 0);
  }
  // So the order of the shapes does not turn the modes round.
  std::swap(shapes[0], shapes[5]);
  std::swap(shapes[1], shapes[3]);
  EXPECT_LT((modelOf(shapes).modes - model.modes).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(ShapeModel, IdenticalShapesHaveNoModes) {
  const Points shape = test::ellipsoids(1, 7).front();
  const ShapeModel model = modelOf({shape, shape, shape});
  EXPECT_EQ(model.modeCount(), 0);
  EXPECT_EQ(model.totalVariance, 0);
  EXPECT_EQ(model.scores.rows(), 3);
  EXPECT_LT(largestDifference(model.mean, shape), 1e-13);
  // Rounding is no variation: a tenth is not exact, and far from the origin coordinates are coarse.
  const Points far = (shape * 0.1).rowwise() + Eigen::RowVector3d(1e4, 0, 0);
  Points nudged = far;
  nudged(3, 0) = std::nextafter(nudged(3, 0), 2e4);
  EXPECT_EQ(modelOf({far, nudged, far}).modeCount(), 0);
  // So with coordinates stored as float, if that is said.
  const Points coarse = far.cast<float>().cast<double>();
  const TrainingSet set = test::trainingSet({far, coarse, far}, test::ellipsoidFaces());
  EXPECT_EQ(buildShapeModel(set, std::numeric_limits<float>::epsilon()).modeCount(), 0);
  EXPECT_EQ(buildShapeModel(set).modeCount(), 1);
}

TEST(ShapeModel, MoreShapesThanCoordinates) {
  const auto tetrahedron = test::tetrahedron();
  std::vector<Points> shapes;
  for (unsigned k = 0; k < 40; ++k)
    shapes.push_back(tetrahedron.vertices + 0.1 * test::randomDirection(4, k));
  const ShapeModel model = buildShapeModel(test::trainingSet(shapes, tetrahedron.faces));
  EXPECT_EQ(model.modeCount(), 12);
  for (int k = 0; k < 40; ++k)
    EXPECT_LT(largestDifference(model.shape(VectorXd(model.scores.row(k).transpose())),
                                shapes[static_cast<size_t>(k)]),
              1e-13);
}

TEST(ShapeModel, ComputesTheModesThatAreAskedFor) {
  const TrainingSet set = test::trainingSet(test::ellipsoids(9, 9), test::ellipsoidFaces());
  const ShapeModel all = buildShapeModel(set);
  const ShapeModel few = buildShapeModel(set, std::numeric_limits<double>::epsilon(), 3);
  EXPECT_EQ(few.modes.cols(), 3);
  EXPECT_EQ(few.modeCount(), 8);
  EXPECT_EQ(few.eigenvalues, all.eigenvalues);
  EXPECT_EQ(few.totalVariance, all.totalVariance);
  EXPECT_LT((few.modes - all.modes.leftCols(3)).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_EQ(few.scores.leftCols(3), all.scores.leftCols(3));
  EXPECT_EQ(few.truncated(5).modeCount(), 3);
}

TEST(ShapeModel, TruncationKeepsTheFirstModes) {
  const ShapeModel model = modelOf(test::ellipsoids(6, 8)), two = model.truncated(2);
  EXPECT_EQ(two.modeCount(), 2);
  EXPECT_EQ(two.modes, model.modes.leftCols(2));
  EXPECT_EQ(two.scores, model.scores.leftCols(2));
  EXPECT_EQ(two.totalVariance, model.totalVariance);
  EXPECT_EQ(model.truncated(100).modeCount(), 5);
  EXPECT_EQ(model.truncated(0).shape(VectorXd(0)), model.mean);
}

}  // namespace
}  // namespace sphere_propagation
