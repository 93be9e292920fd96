// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/outliers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/core/test_shapes.h"
#include "vcg_ext/model/procrustes.h"

namespace sphere_propagation {
namespace {

constexpr Alignment alignments[]{Alignment::Similarity, Alignment::Rigid, Alignment::None};

std::vector<Outlier> outliersOf(const std::vector<Points>& shapes,
                                Alignment alignment = Alignment::Similarity) {
  const TrainingSet set = test::trainingSet(shapes, test::ellipsoidFaces());
  ProcrustesParameters parameters;
  parameters.alignment = alignment;
  return findOutliers(set, alignShapes(set, parameters).shapes);
}

void shuffle(Points& points, unsigned seed) {
  test::Random random(seed);
  for (Eigen::Index j = points.rows() - 1; j > 0; --j) {
    const auto other = static_cast<Eigen::Index>(random.uniform() * static_cast<double>(j + 1));
    points.row(j).swap(points.row(std::min(other, j)));
  }
}

TEST(Outliers, NamesAShapeOfAnotherUnit) {
  for (const int count : {5, 9, 30})
    for (const double factor : {10.0, 0.1, 25.4, 2.5})
      for (const Alignment alignment : alignments) {
        auto shapes = test::ellipsoids(count, 1);
        shapes[3] *= factor;
        const std::vector<Outlier> outliers = outliersOf(shapes, alignment);
        ASSERT_EQ(outliers.size(), 1u) << count << " " << factor;
        EXPECT_EQ(outliers[0].shape, 3u);
        EXPECT_EQ(outliers[0].kind, Outlier::Kind::Size);
        EXPECT_NEAR(outliers[0].ratio, factor, 0.3 * factor);
      }
}

TEST(Outliers, NamesShuffledLandmarksAndMirrorImages) {
  for (const int count : {5, 12, 30})
    for (const Alignment alignment : alignments) {
      auto shapes = test::ellipsoids(count, 2);
      shuffle(shapes[1], 3);
      std::vector<Outlier> outliers = outliersOf(shapes, alignment);
      ASSERT_EQ(outliers.size(), 1u) << count;
      EXPECT_EQ(outliers[0].shape, 1u);
      EXPECT_EQ(outliers[0].kind, Outlier::Kind::Shape);

      shapes = test::ellipsoids(count, 4);
      shapes[0].col(0) *= -1;
      outliers = outliersOf(shapes, alignment);
      ASSERT_EQ(outliers.size(), 1u) << count;
      EXPECT_EQ(outliers[0].shape, 0u);
      EXPECT_GT(outliers[0].distance, 10);
    }
}

TEST(Outliers, NamesSeveral) {
  auto shapes = test::ellipsoids(20, 5);
  shuffle(shapes[2], 6);
  shapes[7] *= 10;
  shapes[11].col(1) *= -1;
  const std::vector<Outlier> outliers = outliersOf(shapes);
  ASSERT_EQ(outliers.size(), 3u);
  EXPECT_EQ(outliers[0].shape, 2u);
  EXPECT_EQ(outliers[1].shape, 7u);
  EXPECT_EQ(outliers[2].shape, 11u);
}

TEST(Outliers, NameTheFewerOfTwoUnits) {
  for (const double factor : {0.1, 25.4, 1000.0})
    for (const size_t odd : {3, 5, 7}) {
      auto shapes = test::ellipsoids(15, 40);
      for (size_t k = 0; k < odd; ++k) shapes[2 * k] *= factor;
      const std::vector<Outlier> outliers = outliersOf(shapes);
      ASSERT_EQ(outliers.size(), odd) << factor;
      for (size_t k = 0; k < odd; ++k) {
        EXPECT_EQ(outliers[k].shape, 2 * k);
        EXPECT_EQ(outliers[k].kind, Outlier::Kind::Size);
        EXPECT_EQ(outliers[k].units, factor < 1 ? 10 : factor);
      }
    }
  auto shapes = test::ellipsoids(8, 41);  // of equals the first shape is right
  for (const size_t k : {1, 2, 5, 7}) shapes[k] /= 10;
  ASSERT_EQ(outliersOf(shapes).size(), 4u);
  EXPECT_EQ(outliersOf(shapes)[0].shape, 1u);
  shapes = test::ellipsoids(12, 42);  // three units
  for (const size_t k : {0, 1, 2}) shapes[k] *= 10;
  for (const size_t k : {3, 4, 5, 6}) shapes[k] /= 100;
  EXPECT_EQ(outliersOf(shapes).size(), 7u);
}

TEST(Outliers, NameAllButOneOfThreeUnits) {
  auto shapes = test::ellipsoids(15, 45);  // of equals that of the first shape is right
  for (size_t k = 0; k < 5; ++k) {
    shapes[3 * k + 1] *= 10;
    shapes[3 * k + 2] *= 1000;
  }
  const std::vector<Outlier> outliers = outliersOf(shapes);
  ASSERT_EQ(outliers.size(), 10u);
  for (const Outlier& outlier : outliers) {
    EXPECT_EQ(outlier.kind, Outlier::Kind::Size);
    EXPECT_EQ(outlier.units, outlier.shape % 3 == 1 ? 10 : 1000);
  }
  // A giant is of no unit, and hides no other.
  shapes = test::ellipsoids(15, 46);
  shapes[2] *= 4.5;
  for (const size_t k : {5, 6, 7}) shapes[k] /= 10;
  EXPECT_EQ(outliersOf(shapes).size(), 4u);
}

TEST(Outliers, NameLandmarksThatStray) {
  for (const int count : {5, 30})
    for (const Alignment alignment : alignments) {
      auto shapes = test::ellipsoids(count, 60);
      const double extent = std::sqrt(shapes[2].rowwise().squaredNorm().mean());
      shapes[2].row(17) += extent * Eigen::RowVector3d(0.3, 0.4, 0);
      shapes[4].row(20) += extent * Eigen::RowVector3d(0, 0.5, 0);
      shapes[4].row(99) += extent * Eigen::RowVector3d(0, 0, 0.7);
      const std::vector<Outlier> outliers = outliersOf(shapes, alignment);
      ASSERT_EQ(outliers.size(), 2u) << count;
      EXPECT_EQ(outliers[0].shape, 2u);
      EXPECT_EQ(outliers[0].kind, Outlier::Kind::Landmarks);
      EXPECT_EQ(outliers[0].landmarks, std::vector<int>{17});
      EXPECT_NEAR(outliers[0].distance, 0.5 * extent, 0.1 * extent);
      EXPECT_EQ(outliers[1].shape, 4u);
      EXPECT_EQ(outliers[1].landmarks, (std::vector<int>{99, 20}));
    }
}

TEST(Outliers, NameALandmarkAndNotTheSizeThatItMakes) {
  for (const Alignment alignment : alignments)
    for (const double far : {30.0, 300.0}) {
      auto shapes = test::ellipsoids(12, 62);
      const double extent = std::sqrt(shapes[2].rowwise().squaredNorm().mean());
      shapes[2].row(17) += far * extent * Eigen::RowVector3d(0, 0.6, 0.8);
      const std::vector<Outlier> outliers = outliersOf(shapes, alignment);
      ASSERT_EQ(outliers.size(), 1u) << far;
      EXPECT_EQ(outliers[0].kind, Outlier::Kind::Landmarks) << far;
      EXPECT_EQ(outliers[0].landmarks, std::vector<int>{17});
    }
}

TEST(RepeatedShapes, AreTheSameOnceAligned) {
  auto shapes = test::ellipsoids(8, 63);
  shapes[5] = 2 * (shapes[1].rowwise() + Eigen::RowVector3d(3, 4, 5));
  shapes[6] = shapes[1];
  const auto repeated = [&](Alignment alignment) {
    ProcrustesParameters parameters;
    parameters.alignment = alignment;
    const TrainingSet set = test::trainingSet(shapes, test::ellipsoidFaces());
    return repeatedShapes(alignShapes(set, parameters).shapes);
  };
  EXPECT_EQ(repeated(Alignment::Similarity), (std::vector<int>{-1, -1, -1, -1, -1, 1, 1, -1}));
  EXPECT_EQ(repeated(Alignment::None), (std::vector<int>{-1, -1, -1, -1, -1, -1, 1, -1}));
}

TEST(Outliers, NameLandmarksThatAreExchanged) {
  auto shapes = test::ellipsoids(12, 61);
  shapes[7].row(3).swap(shapes[7].row(140));
  const std::vector<Outlier> outliers = outliersOf(shapes);
  ASSERT_EQ(outliers.size(), 1u);
  EXPECT_EQ(outliers[0].shape, 7u);
  ASSERT_EQ(outliers[0].landmarks.size(), 2u);
  EXPECT_EQ(outliers[0].landmarks[0] + outliers[0].landmarks[1], 143);
}

TEST(Outliers, NameUpToHalfOfTheShapesWhereLandmarksAreShuffled) {
  auto shapes = test::ellipsoids(21, 43);
  for (unsigned k = 0; k < 9; ++k) shuffle(shapes[2 * k], 50 + k);
  const std::vector<Outlier> outliers = outliersOf(shapes);
  ASSERT_EQ(outliers.size(), 9u);
  for (size_t k = 0; k < 9; ++k) EXPECT_EQ(outliers[k].shape, 2 * k);
  // Two kinds of one organ are none, however many of each.
  for (const size_t fewer : {3, 6, 10}) {
    shapes = test::ellipsoids(21, 44);
    for (size_t k = 0; k < fewer; ++k) shapes[k].col(2) *= 1.5;
    for (const Outlier& outlier : outliersOf(shapes)) ADD_FAILURE() << fewer << outlier.shape;
  }
}

TEST(Outliers, AreNotThereInNaturalPopulations) {
  for (const Alignment alignment : alignments) {
    for (unsigned seed = 0; seed < 5; ++seed)
      EXPECT_TRUE(outliersOf(test::ellipsoids(40, 10 + seed), alignment).empty());
    // One mode, as in a cycle and as in a large population; some of the sizes vary by two.
    const Points mean = test::ellipsoids(1, 20).front(), u = test::randomDirection(162, 21);
    test::Random random(22);
    std::vector<Points> line, cycle, sizes;
    for (int k = 0; k < 1000; ++k) line.push_back(mean + 25 * random.normal() * u);
    for (int k = 0; k < 25; ++k) {
      const double fill = std::max(0.0, std::sin(0.25 * k));  // long at rest, short in between
      cycle.push_back(mean + 80 * fill * u);
    }
    for (int k = 0; k < 30; ++k) sizes.push_back(std::exp2(random.normal() / 3) * mean);
    EXPECT_TRUE(outliersOf(line, alignment).empty());
    EXPECT_TRUE(outliersOf(cycle, alignment).empty());
    EXPECT_TRUE(outliersOf(sizes, alignment).empty());
  }
}

TEST(Outliers, NeedOthersToStandOutFrom) {
  auto shapes = test::ellipsoids(4, 7);
  shapes[0] *= 10;
  EXPECT_TRUE(outliersOf(shapes).empty());
  const Points one = test::ellipsoids(1, 8).front();
  EXPECT_TRUE(outliersOf({one, one, one, one, one, one}).empty());
}

}  // namespace
}  // namespace sphere_propagation
