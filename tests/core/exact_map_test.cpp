// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/anchors/exact_map.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <vector>

#include "tests/core/test_meshes.h"
#include "vcg_ext/anchors/snapped_map.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/sphere/certificate.h"
#include "vcg_ext/sphere/map_measures.h"

namespace sphere_propagation {
namespace {

MappedSurface ballMap(int frequency = 16) {
  const test::Mesh mesh = test::icosphereMesh(frequency);
  return MappedSurface(surfaceOf(mesh, "ball"), mesh.vertices);
}

struct Moves {
  std::vector<SurfacePoint> points;
  std::vector<Vector3> targets;
  std::vector<std::string> names;
};

/// Six points off the vertices, to be moved by so much in ways that have nothing in common.
Moves moves(const MappedSurface& map, double angle, int seed = 0) {
  Moves made;
  for (int k = 0; k < 6; ++k) {
    SurfacePoint point;
    point.face = static_cast<int>(map.faces().rows()) * (2 * k + 1) / 13;
    point.weights = Vector3(0.5, 0.3, 0.2);
    const Vector3 place = placeOf(map, point);
    const Vector3 axis = place.cross(test::randomRotation(k + 6 * seed).col(0)).normalized();
    made.points.push_back(point);
    made.targets.emplace_back(Eigen::AngleAxisd(angle, axis) * place);
    made.names.push_back("anchor " + std::to_string(k));
  }
  return made;
}

double farthest(const MappedSurface& map, const Moves& moves) {
  double most = 0;
  for (size_t k = 0; k < moves.points.size(); ++k) {
    const Vector3 place = placeOf(map, moves.points[k]);
    most = std::max(most, place.cross(moves.targets[k]).norm());
  }
  return most;
}

TEST(ExactMap, BringsPointsToTheirPlacesAndStaysValid) {
  const MappedSurface map = ballMap();
  for (const double angle : {1e-6, 0.1, 0.4}) {
    const Moves asked = moves(map, angle);
    ASSERT_GT(farthest(map, asked), 0.9 * std::sin(angle));
    const ExactMap held = holdExactly(map, asked.points, asked.targets, asked.names);
    EXPECT_LT(farthest(held.map, asked), 1e-12) << angle;
    EXPECT_TRUE(certify(map.faces(), held.map.positions()).valid());
    EXPECT_NEAR(held.longestWay, angle, 1e-9);
    EXPECT_LT(held.steps, 30);
  }
}

TEST(ExactMap, LeavesAMapThatHoldsThemAlready) {
  const MappedSurface map = ballMap();
  const Moves asked = moves(map, 0);
  EXPECT_EQ(holdExactly(map, asked.points, asked.targets, asked.names).map.positions(),
            map.positions());
  EXPECT_EQ(holdExactly(map, {}, {}, {}).map.positions(), map.positions());
}

TEST(ExactMap, SpreadsFarWaysOverTheSphere) {
  // The flow alone leaves 15 degrees here, where there were none.
  const MappedSurface map = ballMap();
  const Moves asked = moves(map, 0.6);
  const ExactMap held = holdExactly(map, asked.points, asked.targets, asked.names);
  EXPECT_LT(farthest(held.map, asked), 1e-12);
  EXPECT_TRUE(certify(map.faces(), held.map.positions()).valid());
  EXPECT_LT(measureMap(map.surface(), held.map.positions()).angleErrorMean, 11);
}

struct HardMoves {
  double angle;
  int seed;
};

class ExactMapOfFewFaces : public testing::TestWithParam<HardMoves> {};

TEST_P(ExactMapOfFewFaces, IsFoundInOneWayOrAnother) {
  const MappedSurface map = ballMap(4);
  const Moves asked = moves(map, GetParam().angle, GetParam().seed);
  const ExactMap held = holdExactly(map, asked.points, asked.targets, asked.names);
  EXPECT_LT(farthest(held.map, asked), 1e-12);
  EXPECT_TRUE(certify(map.faces(), held.map.positions()).valid());
}

INSTANTIATE_TEST_SUITE_P(ByHalfStepsAlone, ExactMapOfFewFaces, testing::Values(HardMoves{0.9, 11}));
INSTANTIATE_TEST_SUITE_P(ByMendingAlone, ExactMapOfFewFaces, testing::Values(HardMoves{2.0, 20}));
INSTANTIATE_TEST_SUITE_P(ByTheFlowAlone, ExactMapOfFewFaces,
                         testing::Values(HardMoves{0.6, 2}, HardMoves{0.6, 4}));

TEST(ExactMap, NamesTheOneThatStaysOffWhereNoMapHoldsThem) {
  // Three of one face, one of them beyond the other two: the face would have to turn over.
  const MappedSurface map = ballMap(4);
  Moves asked;
  for (int k = 0; k < 3; ++k) {
    SurfacePoint point;
    point.face = 7;
    point.weights = Vector3::Constant(0.2) + 0.4 * Vector3::Unit(k);
    asked.points.push_back(point);
    asked.targets.push_back(placeOf(map, point));
    asked.names.push_back("anchor " + std::to_string(k));
  }
  asked.targets[2] = (asked.targets[0] + asked.targets[1] - asked.targets[2]).normalized();
  try {
    holdExactly(map, asked.points, asked.targets, asked.names);
    FAIL() << "no face can be turned over";
  } catch (const AnchorError& error) {
    EXPECT_EQ(error.finding().fault, Fault::AnchorsNotHeld);
    EXPECT_EQ(error.finding().name, "ball");
    EXPECT_EQ(error.finding().other.rfind("anchor ", 0), 0U);
    EXPECT_GT(error.finding().value, exactDistance);
  }
}

TEST(SnappedMap, MakesPointsLandmarksEachOneOfItsOwn) {
  const MappedSurface map = ballMap();
  Moves asked = moves(map, 0);
  asked.points.push_back(asked.points[0]);  // near another one: they cannot share a landmark
  asked.points.back().weights = Vector3(0.3, 0.5, 0.2);
  asked.names.emplace_back("anchor 6");
  const SnappedMap snapped = snapToLandmarks(map, asked.points, asked.names);
  EXPECT_TRUE(certify(map.faces(), snapped.map.positions()).valid());
  const Points vertices = icosphere(snapFrequency).vertices;
  EXPECT_NE(snapped.landmarks[0], snapped.landmarks[6]);
  for (size_t k = 0; k < asked.points.size(); ++k) {
    const Vector3 landmark = vertices.row(snapped.landmarks[k]).transpose();
    EXPECT_LT((placeOf(snapped.map, asked.points[k]) - landmark).norm(), 2e-12);
    if (k % 6 != 0) {
      EXPECT_EQ((vertices * placeOf(map, asked.points[k])).maxCoeff(),
                landmark.dot(placeOf(map, asked.points[k])));
    }
  }
}

TEST(ExactMap, NamesThoseThatChangePlacesOrLieInOne) {
  const MappedSurface map = ballMap();
  const auto refusal = [&](const Moves& asked) {
    try {
      holdExactly(map, asked.points, asked.targets, asked.names);
    } catch (const AnchorError& error) {
      return error.finding();
    }
    return Finding(Fault::Text);
  };
  Moves swapped = moves(map, 0.05);
  std::swap(swapped.targets[1], swapped.targets[4]);
  EXPECT_EQ(refusal(swapped).fault, Fault::AnchorsChangePlaces);
  EXPECT_EQ(refusal(swapped).other, "anchor 1");
  EXPECT_EQ(refusal(swapped).detail, "anchor 4");
  Moves one = moves(map, 0.05);
  one.points[3] = one.points[2];
  EXPECT_EQ(refusal(one).fault, Fault::AnchorsInOnePlace);
  EXPECT_EQ(refusal(one).name, "ball");
}

}  // namespace
}  // namespace sphere_propagation
