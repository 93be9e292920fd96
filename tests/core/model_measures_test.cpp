// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/model_measures.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/test_shapes.h"
#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

using Eigen::VectorXd;

using test::modelOf;

/// mean + c_k u, |u| = 1, for each c.
std::vector<Points> onALine(const std::vector<double>& c) {
  const Points mean = test::ellipsoids(1, 1).front(), u = test::randomDirection(162, 2);
  std::vector<Points> shapes;
  for (const double amount : c) shapes.push_back(mean + amount * u);
  return shapes;
}

const double root = std::sqrt(162.0);  // |x - y| = root d(x, y)

double distance(const Points& a, const Points& b) { return (a - b).norm() / root; }

double density(double x) { return std::exp(-x * x / 2) / std::sqrt(2 * pi); }
double below(double x) { return std::erfc(-x / std::sqrt(2.0)) / 2; }

/// E min(|s g - a|, |s g + a|) for a standard normal g: the mean distance of samples from the
/// nearer of two points.
double distanceToTwo(double s, double a) {
  const double c = a / s;  // s E | |g| - c |, E | |g| - c | = E|g| - c + 2 E max(c - |g|, 0)
  const double under = 2 * (c * (below(c) - 0.5) - (density(0) - density(c)));
  return s * (std::sqrt(2 / pi) - c + 2 * under);
}

TEST(ModelMeasures, AllVarianceInOneMode) {
  const ShapeModel model = modelOf(onALine({-3, 1, 4, 6}));
  const ModelMeasures measures = measureModel(model, model.modeCount());
  ASSERT_EQ(measures.compactness.size(), 1);
  EXPECT_NEAR(measures.compactness[0], 46.0 / 3, 1e-10);
  EXPECT_NEAR(measures.generalisation[0], 0, 1e-10);  // any three of them span the line
  EXPECT_NEAR(measures.generalisationError[0], 0, 1e-10);
}

TEST(ModelMeasures, TwoShapes) {
  // At -a and a: the variance is 2 a^2; without one of them no mode is left, and the other is all
  // there is.
  const double a = 5;
  const ShapeModel model = modelOf(onALine({-a, a}));
  ModelMeasureParameters parameters;
  parameters.samples = 200000;
  const ModelMeasures measures = measureModel(model, 1, parameters);
  EXPECT_NEAR(measures.compactness[0], 2 * a * a, 1e-9);
  EXPECT_NEAR(measures.generalisation[0], 2 * a / root, 1e-10);
  const double expected = distanceToTwo(std::sqrt(2.0) * a, a) / root;
  EXPECT_LT(measures.specificityError[0], 0.005 * expected);
  EXPECT_NEAR(measures.specificity[0], expected, 4 * measures.specificityError[0]);
}

TEST(ModelMeasures, TwoClusters) {
  // n shapes at each of -a and a: variance 2 n a^2 / (2 n - 1), and whichever is left out, the
  // others span the line.
  const double a = 3;
  const int n = 4;
  const ShapeModel model = modelOf(onALine({-a, -a, -a, -a, a, a, a, a}));
  ASSERT_EQ(model.modeCount(), 1);
  ModelMeasureParameters parameters;
  parameters.samples = 200000;
  const ModelMeasures measures = measureModel(model, 1, parameters);
  const double variance = 2.0 * n * a * a / (2 * n - 1);
  EXPECT_NEAR(measures.compactness[0], variance, 1e-9);
  EXPECT_NEAR(measures.generalisation[0], 0, 1e-10);
  EXPECT_NEAR(measures.specificity[0], distanceToTwo(std::sqrt(variance), a) / root,
              4 * measures.specificityError[0]);
}

TEST(ModelMeasures, OrthogonalCorners) {
  // x_k = mean + a e_k with orthonormal e_k: whatever is left out is orthogonal to the others'
  // modes, so no number of modes helps: G = a sqrt(1 + 1 / (K - 1)), the distance to the centre of
  // the others.
  const Points mean = test::ellipsoids(1, 3).front();
  std::vector<Points> shapes;
  for (int k = 0; k < 5; ++k) {
    Points shape = mean;
    shape(20 * k, 1) += 7;
    shapes.push_back(shape);
  }
  const ShapeModel model = modelOf(shapes);
  ASSERT_EQ(model.modeCount(), 4);
  const ModelMeasures measures = measureModel(model, 4);
  for (int m = 0; m < 4; ++m)
    EXPECT_NEAR(measures.generalisation[m], 7 * std::sqrt(1.25) / root, 1e-10);
  EXPECT_NEAR(measures.generalisationError.maxCoeff(), 0, 1e-10);
  for (int m = 0; m < 4; ++m) EXPECT_NEAR(measures.compactness[m], (m + 1) * 49.0 / 4, 1e-9);
}

TEST(ModelMeasures, IdenticalShapes) {
  const ShapeModel model = modelOf(onALine({1, 1, 1}));
  const ModelMeasures measures = measureModel(model, model.modeCount());
  for (const VectorXd* figure :
       {&measures.compactness, &measures.generalisation, &measures.specificity,
        &measures.generalisationError, &measures.specificityError})
    EXPECT_EQ(figure->size(), 0);
}

TEST(ModelMeasures, GeneralisationByItsDefinition) {
  const auto shapes = test::ellipsoids(6, 4);
  const ShapeModel model = modelOf(shapes);
  const ModelMeasures measures = measureModel(model, 5);
  for (int m = 1; m <= 5; ++m) {
    VectorXd distances(6);
    for (size_t left = 0; left < 6; ++left) {
      auto others = shapes;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(left));
      const ShapeModel rest = modelOf(others).truncated(m);
      const Points away = shapes[left] - rest.mean;
      const VectorXd b =
          rest.modes.transpose() * Eigen::Map<const VectorXd>(away.data(), away.size());
      distances[static_cast<Eigen::Index>(left)] = distance(rest.shape(b), shapes[left]);
    }
    EXPECT_NEAR(measures.generalisation[m - 1], distances.mean(), 1e-10);
    EXPECT_NEAR(measures.generalisationError[m - 1],
                std::sqrt((distances.array() - distances.mean()).square().mean() / 5), 1e-10);
  }
  EXPECT_EQ(measures.generalisation[3], measures.generalisation[4]);  // five shapes have four modes
}

TEST(ModelMeasures, SpecificityCountsWhatTheModesLeaveOut) {
  // With the first mode alone, samples lie on a line, while the shapes lie off it too: the mean
  // distance is at least the smallest distance of a shape from the line.
  const ShapeModel model = modelOf(test::ellipsoids(5, 5, 3.0));
  const ModelMeasures measures = measureModel(model, 1);
  const double offTheLine = model.scores.rightCols(3).rowwise().norm().minCoeff() / root;
  ASSERT_GT(offTheLine, 0.1);
  EXPECT_GT(measures.specificity[0], offTheLine);
}

TEST(ModelMeasures, FewerModesAreTheSameFigures) {
  const ShapeModel model = modelOf(test::ellipsoids(6, 6));
  const ModelMeasures all = measureModel(model, 5), two = measureModel(model, 2);
  EXPECT_EQ(two.compactness, all.compactness.head(2));
  EXPECT_LT((two.generalisation - all.generalisation.head(2)).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(ModelMeasures, SeedsDecideTheSamples) {
  const ShapeModel model = modelOf(test::ellipsoids(6, 7));
  ModelMeasureParameters parameters;
  const VectorXd first = measureModel(model, 5, parameters).specificity;
  EXPECT_EQ(measureModel(model, 5, parameters).specificity, first);
  parameters.seed = 1;
  const ModelMeasures other = measureModel(model, 5, parameters);
  EXPECT_NE(other.specificity, first);
  EXPECT_LT((other.specificity - first).cwiseQuotient(other.specificityError).cwiseAbs().maxCoeff(),
            5);
}

TEST(ModelMeasures, AreTheSameWithAnyNumberOfThreads) {
  const ShapeModel model = modelOf(test::ellipsoids(20, 9));
  ModelMeasureParameters parameters;
  parameters.samples = 300;
  parameters.threads = 1;
  const ModelMeasures one = measureModel(model, 19, parameters);
  parameters.threads = 3;
  const ModelMeasures three = measureModel(model, 19, parameters);
  EXPECT_EQ(three.generalisation, one.generalisation);
  EXPECT_EQ(three.specificity, one.specificity);
  EXPECT_EQ(three.specificityError, one.specificityError);
}

TEST(ModelMeasures, RefusesWhatMakesNoSense) {
  const ShapeModel model = modelOf(test::ellipsoids(3, 8));
  ModelMeasureParameters parameters;
  for (const int samples : {0, -1, 1'000'001}) {
    parameters.samples = samples;
    EXPECT_THROW(measureModel(model, 1, parameters), ParameterError);
  }
  EXPECT_THROW(measureModel(model, -1), ParameterError);
  parameters = {};
  parameters.threads = -1;
  EXPECT_THROW(measureModel(model, 1, parameters), ParameterError);
}

}  // namespace
}  // namespace sphere_propagation
