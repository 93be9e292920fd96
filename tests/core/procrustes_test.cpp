// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/procrustes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/core/test_shapes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/model/shape_model.h"

namespace sphere_propagation {
namespace {

ProcrustesParameters with(Alignment alignment, bool areaWeights = false) {
  ProcrustesParameters parameters;
  parameters.alignment = alignment;
  parameters.areaWeights = areaWeights;
  return parameters;
}

double size(const Points& points) { return (points.rowwise() - points.colwise().mean()).norm(); }

using test::largestDifference;

/// Each shape somewhere else; where not rigid, in another size too.
std::vector<Points> scattered(std::vector<Points> shapes, bool rigid, unsigned seed) {
  test::Random random(seed);
  for (size_t k = 0; k < shapes.size(); ++k) {
    const double scale = rigid ? 1 : random.uniform(0.5, 2);
    shapes[k] = test::moved(shapes[k], test::randomRotation(seed + static_cast<unsigned>(k)), scale,
                            100 * random.direction());
  }
  return shapes;
}

double objective(const std::vector<Points>& shapes) {
  Points mean = Points::Zero(shapes.front().rows(), 3);
  for (const Points& shape : shapes) mean += shape / static_cast<double>(shapes.size());
  double sum = 0;
  for (const Points& shape : shapes) sum += (shape - mean).squaredNorm();
  return sum / mean.squaredNorm();
}

TEST(AlignShapes, BringsMovedCopiesTogether) {
  const Points shape = test::ellipsoids(1, 1).front();
  for (const bool rigid : {true, false}) {
    const auto shapes = scattered({shape, shape, shape, shape}, rigid, 2);
    const Aligned aligned = alignShapes(test::trainingSet(shapes, test::ellipsoidFaces()),
                                        with(rigid ? Alignment::Rigid : Alignment::Similarity));
    EXPECT_TRUE(aligned.converged);
    for (const auto& [name, landmarks] : aligned.shapes.shapes())
      EXPECT_LT(largestDifference(landmarks, aligned.mean), 1e-11) << name;
    EXPECT_NEAR(buildShapeModel(aligned.shapes).totalVariance, 0, 1e-20);
  }
}

TEST(AlignShapes, EigenvaluesDoNotDependOnThePose) {
  const auto shapes = test::ellipsoids(8, 3);
  for (const bool weights : {false, true}) {
    const auto parameters = with(Alignment::Rigid, weights);
    const Eigen::VectorXd expected =
        buildShapeModel(
            alignShapes(test::trainingSet(shapes, test::ellipsoidFaces()), parameters).shapes)
            .eigenvalues;
    ASSERT_EQ(expected.size(), 7);
    for (unsigned seed = 10; seed < 13; ++seed) {
      const auto found = buildShapeModel(
          alignShapes(test::trainingSet(scattered(shapes, true, seed), test::ellipsoidFaces()),
                      parameters)
              .shapes);
      EXPECT_LT((found.eigenvalues - expected).cwiseQuotient(expected).cwiseAbs().maxCoeff(), 1e-9);
    }
  }
}

TEST(AlignShapes, EigenvaluesDoNotDependOnTheSizesButForTheirAverage) {
  const auto shapes = test::ellipsoids(8, 4);
  for (const bool weights : {false, true}) {
    const auto parameters = with(Alignment::Similarity, weights);
    const Aligned expected =
        alignShapes(test::trainingSet(shapes, test::ellipsoidFaces()), parameters);
    const Eigen::VectorXd eigenvalues =
        buildShapeModel(expected.shapes).eigenvalues / std::pow(size(expected.mean), 2);
    for (unsigned seed = 20; seed < 23; ++seed) {
      const Aligned aligned = alignShapes(
          test::trainingSet(scattered(shapes, false, seed), test::ellipsoidFaces()), parameters);
      const Eigen::VectorXd found =
          buildShapeModel(aligned.shapes).eigenvalues / std::pow(size(aligned.mean), 2);
      EXPECT_LT((found - eigenvalues).cwiseQuotient(eigenvalues).cwiseAbs().maxCoeff(), 1e-9);
    }
  }
}

TEST(AlignShapes, KeepsTheFrameOfTheFirstShapeAndTheAverageSize) {
  const auto shapes = scattered(test::ellipsoids(5, 5), false, 6);
  const Aligned aligned = alignShapes(test::trainingSet(shapes, test::ellipsoidFaces()));
  const Points& first = aligned.shapes.shapes().front().landmarks;
  EXPECT_LT((aligned.mean.colwise().mean() - shapes[0].colwise().mean()).norm(), 1e-10);
  // The first shape is only scaled about its centroid.
  const Points centred = shapes[0].rowwise() - shapes[0].colwise().mean();
  const double scale = size(first) / size(shapes[0]);
  EXPECT_LT(largestDifference((scale * centred).rowwise() + shapes[0].colwise().mean(), first),
            1e-10);
  double sizes = 0;
  for (const Points& shape : shapes) sizes += size(shape) / 5;
  EXPECT_NEAR(size(aligned.mean), sizes, 1e-10);
  // The mean is the average.
  Points average = Points::Zero(first.rows(), 3);
  for (const auto& [name, landmarks] : aligned.shapes.shapes()) average += landmarks / 5;
  EXPECT_LT(largestDifference(average, aligned.mean), 1e-12);
}

TEST(AlignShapes, RigidKeepsSizes) {
  const auto shapes = scattered(test::ellipsoids(4, 7), true, 8);
  const Aligned aligned =
      alignShapes(test::trainingSet(shapes, test::ellipsoidFaces()), with(Alignment::Rigid));
  for (size_t k = 0; k < shapes.size(); ++k)
    EXPECT_NEAR(size(aligned.shapes.shapes()[k].landmarks), size(shapes[k]), 1e-10);
  EXPECT_LT(largestDifference(aligned.shapes.shapes()[0].landmarks, shapes[0]), 1e-10);
}

TEST(AlignShapes, NoneChangesNothing) {
  const auto shapes = scattered(test::ellipsoids(3, 9), false, 10);
  const Aligned aligned =
      alignShapes(test::trainingSet(shapes, test::ellipsoidFaces()), with(Alignment::None));
  for (size_t k = 0; k < shapes.size(); ++k)
    EXPECT_EQ(aligned.shapes.shapes()[k].landmarks, shapes[k]);
  EXPECT_LT(largestDifference(aligned.mean, (shapes[0] + shapes[1] + shapes[2]) / 3), 1e-12);
}

TEST(AlignShapes, IsAMinimum) {
  const auto shapes = scattered(test::ellipsoids(5, 11), false, 12);
  const Aligned aligned = alignShapes(test::trainingSet(shapes, test::ellipsoidFaces()));
  std::vector<Points> found;
  for (const auto& [name, landmarks] : aligned.shapes.shapes())
    found.push_back(landmarks.rowwise() - aligned.mean.colwise().mean());
  const double least = objective(found);
  test::Random random(13);
  for (int i = 0; i < 40; ++i) {
    std::vector<Points> other = found;
    Points& changed = other[static_cast<size_t>(random.index(5))];
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(random.uniform(0.003, 0.1), random.direction()).toRotationMatrix();
    changed = test::moved(changed, turn, 1 + random.uniform(-0.02, 0.02), 0.1 * random.direction());
    EXPECT_GT(objective(other), least);
  }
}

TEST(AlignShapes, DoesNotReflect) {
  auto shapes = test::ellipsoids(2, 14, 1.0);
  shapes[1] = shapes[0];
  shapes[1].col(0) *= -1;
  const Aligned aligned = alignShapes(test::trainingSet(shapes, test::ellipsoidFaces()));
  EXPECT_GT(enclosedVolume(shapes[0], test::ellipsoidFaces()), 0);
  EXPECT_LT(enclosedVolume(aligned.shapes.shapes()[1].landmarks, test::ellipsoidFaces()), 0);
}

TEST(AlignShapes, AreaWeightsAreThoseOfTheMean) {
  // A dense patch moves against the rest. With equal weights it drags the centroid; by area it
  // weighs little.
  const test::Mesh mesh = test::rings(1e-3);
  const Eigen::VectorXd areas = vertexAreas(mesh.vertices, mesh.faces);
  ASSERT_GT(areas.maxCoeff(), 1e4 * areas.minCoeff());
  Points moved = mesh.vertices;
  moved.topRows(1 + 8 * 6).rowwise() += Eigen::RowVector3d(0.1, 0, 0);
  const auto set = test::trainingSet({mesh.vertices, moved}, mesh.faces);
  const auto restMoves = [&](bool weights) {
    const Aligned aligned = alignShapes(set, with(Alignment::Rigid, weights));
    const auto& shapes = aligned.shapes.shapes();
    return (shapes[1].landmarks.bottomRows(9) - shapes[0].landmarks.bottomRows(9))
        .rowwise()
        .norm()
        .maxCoeff();
  };
  EXPECT_LT(restMoves(true), 0.01);
  EXPECT_GT(restMoves(false), 0.03);
}

TEST(AlignShapes, IsDeterministic) {
  const auto set =
      test::trainingSet(scattered(test::ellipsoids(4, 15), false, 16), test::ellipsoidFaces());
  EXPECT_EQ(alignShapes(set).mean, alignShapes(set).mean);
}

TEST(AlignShapes, SaysWhenItDidNotConverge) {
  const auto set =
      test::trainingSet(scattered(test::ellipsoids(4, 17), false, 18), test::ellipsoidFaces());
  ProcrustesParameters parameters;
  parameters.iterations = 1;
  EXPECT_FALSE(alignShapes(set, parameters).converged);
  parameters.iterations = 0;
  EXPECT_THROW(alignShapes(set, parameters), ParameterError);
  parameters = {};
  parameters.tolerance = std::nan("");
  EXPECT_THROW(alignShapes(set, parameters), ParameterError);
}

TEST(AlignShapes, NamesAShapeWithoutSize) {
  auto shapes = test::ellipsoids(3, 19);
  shapes[2].rowwise() = Eigen::RowVector3d(1, 2, 3);
  const auto set = test::trainingSet(shapes, test::ellipsoidFaces());
  try {
    alignShapes(set);
    FAIL();
  } catch (const ParameterError& error) {
    EXPECT_NE(std::string(error.what()).find("\"shape 2\""), std::string::npos) << error.what();
  }
  EXPECT_NO_THROW(alignShapes(set, with(Alignment::Rigid)));
}

}  // namespace
}  // namespace sphere_propagation
