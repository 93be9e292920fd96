// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/root_map/placed_root_map.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "tests/core/test_meshes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/root_map/root_map.h"
#include "vcg_ext/sphere/certificate.h"
#include "vcg_ext/sphere/map_measures.h"

namespace sphere_propagation {
namespace {

struct Asked {
  std::vector<SurfacePoint> points;
  std::vector<Vector3> places;
  std::vector<std::string> names;
};

Asked some(const MappedSurface& map, double angle, unsigned seed) {
  const Eigen::Matrix3d turn = test::randomRotation(seed);
  Asked asked;
  for (int k = 0; k < 5; ++k) {
    SurfacePoint point;
    point.face = map.surface().faceCount() * (2 * k + 1) / 11;
    point.weights = Vector3(0.6, 0.1, 0.3);
    const Vector3 place = placeOf(map, point);
    const Vector3 axis = place.cross(test::randomRotation(static_cast<unsigned>(k)).col(1));
    asked.points.push_back(point);
    asked.places.emplace_back(turn * (Eigen::AngleAxisd(angle, axis.normalized()) * place));
    asked.names.push_back("anchor " + std::to_string(k));
  }
  return asked;
}

TEST(PlacedRootMap, HasAnchorsAtTheirPlacesAndAreasAsFarAsTheyAllow) {
  const ClosedSurface surface = surfaceOf(test::noisyEllipsoid(3), "root");
  const MappedSurface map = makeRootMap(surface).map;
  const double sd = measureMap(surface, map.positions()).areaRatioSd;
  for (const double angle : {0.0, 0.1, 0.3}) {
    const Asked asked = some(map, angle, 7);
    const PlacedRootMap placed = placeAnchors(map, asked.points, asked.places, asked.names, 0.9);
    EXPECT_TRUE(certify(map.faces(), placed.map.positions()).valid());
    for (size_t k = 0; k < asked.points.size(); ++k)
      EXPECT_LT((placeOf(placed.map, asked.points[k]) - asked.places[k]).norm(), 2e-12);
    EXPECT_LE(placed.longestWay, 1.5 * angle + 1e-7);
    const MappedSurface unrestored = holdExactly(
                                         map, asked.points,
                                         [&] {
                                           std::vector<Vector3> back = asked.places;
                                           for (Vector3& place : back)
                                             place = test::randomRotation(7).transpose() * place;
                                           return back;
                                         }(),
                                         asked.names)
                                         .map;
    const double restored = measureMap(surface, placed.map.positions()).areaRatioSd,
                 before = measureMap(surface, unrestored.positions()).areaRatioSd;
    if (angle == 0)
      EXPECT_LT(restored, 1.1 * sd + 1e-3) << "turned alone";
    else
      EXPECT_LT(restored, 0.6 * before) << angle << " " << sd;
  }
}

TEST(PlacedRootMap, TakesOneAnchorAndNone) {
  const ClosedSurface surface = surfaceOf(test::ellipsoid(3, 2, 1, 6), "root");
  const MappedSurface map = makeRootMap(surface).map;
  Asked asked = some(map, 0, 5);
  asked.points.resize(1);
  asked.places = {Vector3(0, 0, 1)};
  asked.names.resize(1);
  const PlacedRootMap placed = placeAnchors(map, asked.points, asked.places, asked.names, 0.9);
  EXPECT_LT((placeOf(placed.map, asked.points[0]) - asked.places[0]).norm(), 2e-12);
  EXPECT_LT(placed.longestWay, 1e-7);
  EXPECT_EQ(placeAnchors(map, {}, {}, {}, 0.9).map.positions(), map.positions());
}

TEST(PlacedRootMap, RefusesPlacesThatCannotBe) {
  const ClosedSurface surface = surfaceOf(test::ellipsoid(3, 2, 1, 6), "root");
  const MappedSurface map = makeRootMap(surface).map;
  Asked asked = some(map, 0, 5);
  asked.places[1] = asked.places[3];
  EXPECT_THROW(placeAnchors(map, asked.points, asked.places, asked.names, 0.9), AnchorError);
}

}  // namespace
}  // namespace sphere_propagation
