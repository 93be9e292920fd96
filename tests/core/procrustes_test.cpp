// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/procrustes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/core/test_shapes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/base/rotation.h"
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

/// Points of a shape that are no landmarks, one for each of four corners.
Points anchorsOf(const Points& shape) {
  const Eigen::RowVector3d middle = shape.colwise().mean();
  Points anchors(4, 3);
  for (Eigen::Index k = 0; k < 4; ++k)
    anchors.row(k) = 0.5 * (middle + shape.row(3 * k + 1)) + 0.1 * shape.row(k);
  return anchors;
}

const double missing = std::nan("");

Fault refusalOf(const std::vector<Points>& shapes, const std::vector<Points>& anchors,
                std::string& name, long& count) {
  try {
    alignByAnchors(test::trainingSet(shapes, test::ellipsoidFaces()), anchors, false);
  } catch (const ParameterError& error) {
    name = error.finding().name;
    count = error.finding().count;
    return error.finding().fault;
  }
  return Fault::Text;
}

TEST(AlignByAnchors, RecoversKnownMotionsExactly) {
  const Points shape = test::ellipsoids(1, 1).front();
  const Points anchors = anchorsOf(shape);
  for (const bool scaled : {false, true}) {
    std::vector<Points> shapes, theirs;
    for (unsigned k = 0; k < 4; ++k) {
      const double scale = scaled ? 0.5 + k : 1;
      const Vector3 shift(10.0 * k, -3, 7);
      shapes.push_back(test::moved(shape, test::randomRotation(k), scale, shift));
      theirs.push_back(test::moved(anchors, test::randomRotation(k), scale, shift));
    }
    // Of the last two shapes one has the anchors 0, 1, 2 alone and the other 1, 2, 3.
    theirs[2].row(3).setConstant(missing);
    theirs[3].row(0).setConstant(missing);
    const Aligned aligned =
        alignByAnchors(test::trainingSet(shapes, test::ellipsoidFaces()), theirs, scaled);
    EXPECT_TRUE(aligned.converged);
    for (const auto& [name, landmarks] : aligned.shapes.shapes())
      EXPECT_LT(largestDifference(landmarks, aligned.mean), 1e-11) << name;
    if (scaled) {
      EXPECT_NEAR(size(aligned.mean), 2 * size(shape), 1e-9);  // of .5, 1.5, 2.5, 3.5
    } else {
      EXPECT_LT(largestDifference(aligned.mean, shapes.front()), 1e-11);
    }
  }
}

TEST(AlignByAnchors, WithAllLandmarksForAnchorsIsProcrustes) {
  std::vector<Points> shapes = test::ellipsoids(5, 3);
  for (unsigned k = 0; k < shapes.size(); ++k)
    shapes[k] = test::moved(shapes[k], test::randomRotation(k), 1 + 0.1 * k,
                            Vector3(900 - 30.0 * k, -500, 70));  // far from the origin
  const TrainingSet set = test::trainingSet(shapes, test::ellipsoidFaces());
  for (const bool scaled : {false, true}) {
    const Aligned byAnchors = alignByAnchors(set, shapes, scaled),
                  byAll = alignShapes(set, with(scaled ? Alignment::Similarity : Alignment::Rigid));
    EXPECT_TRUE(byAnchors.converged);
    EXPECT_LT(byAnchors.iterations, 50);
    for (size_t k = 0; k < shapes.size(); ++k)
      EXPECT_LT(largestDifference(byAnchors.shapes.shapes()[k].landmarks,
                                  byAll.shapes.shapes()[k].landmarks),
                1e-9)
          << scaled << ", shape " << k;
  }
}

TEST(AlignByAnchors, LandmarksDoNotCount) {
  // Shapes that differ, with anchors that do not: each is moved by its anchors, none of it is lost.
  const std::vector<Points> shapes = test::ellipsoids(3, 5);
  const Points anchors = anchorsOf(shapes.front());
  std::vector<Points> moved, theirs;
  for (unsigned k = 0; k < 3; ++k) {
    const Vector3 shift(-5.0 * k, 2, 11);
    moved.push_back(test::moved(shapes[k], test::randomRotation(k + 7), 1, shift));
    theirs.push_back(test::moved(anchors, test::randomRotation(k + 7), 1, shift));
  }
  const Aligned aligned =
      alignByAnchors(test::trainingSet(moved, test::ellipsoidFaces()), theirs, false);
  const Eigen::Matrix3d turn = test::randomRotation(7);
  for (size_t k = 0; k < 3; ++k)
    EXPECT_LT(largestDifference(aligned.shapes.shapes()[k].landmarks,
                                test::moved(shapes[k], turn, 1, Vector3(0, 2, 11))),
              1e-11);
}

TEST(AlignByAnchors, ByTheMeanOfWhatIsThere) {
  // By hand: a square of anchors, the last of which lies 4 off on one shape of two. About its
  // centroid neither is turned, so the shapes are one apart, as the centroids are.
  const std::vector<Points> shapes(2, test::ellipsoids(1, 1).front());
  Points square(4, 3);
  square << 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0;
  Points other = square;
  other(3, 2) = 4;
  std::vector<Points> anchors{square, other};
  // The fit to both centroids: 0 and (0, 0, 1).
  const Aligned aligned =
      alignByAnchors(test::trainingSet(shapes, test::ellipsoidFaces()), anchors, false);
  EXPECT_LT(largestDifference(aligned.shapes.shapes()[0].landmarks, shapes[0]), 1e-12);
  const Eigen::Matrix3d correlation =
      square.transpose() * (other.rowwise() - Eigen::RowVector3d(0, 0, 1));
  const Points turned =
      (shapes[1].rowwise() - Eigen::RowVector3d(0, 0, 1)) * bestRotation(correlation).transpose();
  EXPECT_LT(largestDifference(aligned.shapes.shapes()[1].landmarks, turned), 1e-9);
}

TEST(AlignByAnchors, NamesTheShapeWhosePoseStaysOpen) {
  const std::vector<Points> shapes = test::ellipsoids(3, 2);
  const Points anchors = anchorsOf(shapes.front());
  std::vector<Points> theirs(3, anchors);
  std::string name;
  long count = 0;
  theirs[1].row(0).setConstant(missing);
  theirs[1].row(2).setConstant(missing);
  EXPECT_EQ(refusalOf(shapes, theirs, name, count), Fault::FewSharedAnchors);
  EXPECT_EQ(name, "shape 1");
  EXPECT_EQ(count, 2);
  theirs.assign(3, anchors);
  for (Eigen::Index k = 0; k < 4; ++k)
    theirs[2].row(k) =
        Eigen::RowVector3d(1, 2, 3) + static_cast<double>(k) * Eigen::RowVector3d(3, 1, 1);
  EXPECT_EQ(refusalOf(shapes, theirs, name, count), Fault::AnchorsOnOneLine);
  EXPECT_EQ(name, "shape 2");
  theirs.assign(3, Points::Constant(4, 3, missing));
  EXPECT_EQ(refusalOf(shapes, theirs, name, count), Fault::FewSharedAnchors);
  EXPECT_EQ(count, 0);
  theirs.assign(3, Points(0, 3));
  EXPECT_EQ(refusalOf(shapes, theirs, name, count), Fault::FewSharedAnchors);
}

}  // namespace
}  // namespace sphere_propagation
