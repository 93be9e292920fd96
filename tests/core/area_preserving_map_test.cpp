// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/area/area_preserving_map.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "tests/core/sizes.h"
#include "tests/core/test_meshes.h"
#include "vcg_ext/root_map/harmonic_map.h"
#include "vcg_ext/sphere/map_measures.h"

namespace sphere_propagation::test {
namespace {

MappedSurface harmonicMap(const ClosedSurface& surface) {
  return {surface, harmonicPositions(surface)};
}

MapMeasures measuresOf(const ClosedSurface& surface, const MappedSurface& start,
                       double areaWeight) {
  return measureMap(surface, makeAreaPreserving(start, {areaWeight}).map.positions());
}

TEST(AreaPreservingMap, UndoesAKnownDeformation) {
  // The surface is the sphere itself, so a map without any distortion exists.
  const Mesh mesh = icosphereMesh(10);
  const ClosedSurface surface = surfaceOf(mesh);
  for (const double stretch : {1.5, 3.0, 8.0}) {
    Points positions = mesh.vertices;
    for (Eigen::Index v = 0; v < positions.rows(); ++v) {
      const double along =
          std::atan2(positions(v, 1), positions(v, 0)) + positions(v, 2);  // and a twist
      const double across = std::hypot(positions(v, 0), positions(v, 1));
      positions.row(v) << across * std::cos(along), across * std::sin(along),
          stretch * positions(v, 2);
    }
    positions.rowwise().normalize();
    const MappedSurface start(surface, positions);
    EXPECT_GT(measureMap(surface, positions).areaRatioSd, 0.2);
    const AreaPreservingResult result = makeAreaPreserving(start);
    const MapMeasures measures = measureMap(surface, result.map.positions());
    EXPECT_LT(measures.areaRatioSd, 0.005) << "stretched by " << stretch;
    EXPECT_LT(measures.angleErrorMean, 6) << "stretched by " << stretch;
    EXPECT_GT(result.steps, 3);
  }
}

TEST(AreaPreservingMap, AreaWeightTradesAnglesForAreas) {
  for (int seed = 1; seed < sizeFor(4, 2); ++seed) {
    const ClosedSurface surface = surfaceOf(noisyEllipsoid(static_cast<unsigned>(seed)));
    const MappedSurface start = harmonicMap(surface);
    MapMeasures before = measuresOf(surface, start, 0);
    for (const double weight : {0.25, 0.5, 0.75, 0.9, 1.0}) {
      const MapMeasures measures = measuresOf(surface, start, weight);
      EXPECT_LT(measures.areaRatioSd, before.areaRatioSd) << weight;
      EXPECT_GT(measures.angleErrorMean, before.angleErrorMean) << weight;
      before = measures;
    }
    EXPECT_LT(before.areaRatioSd, 0.002);
  }
}

TEST(AreaPreservingMap, AnglesAloneComeBackFromFarAway) {
  // Its own map is conformal; the start is stretched along an axis.
  const Mesh mesh = icosphereMesh(8);
  const ClosedSurface surface = surfaceOf(mesh);
  Points positions = stretched(mesh, 1, 1, 4).vertices;
  positions.rowwise().normalize();
  const double before = measureMap(surface, positions).angleErrorMean;
  EXPECT_LT(measuresOf(surface, MappedSurface(surface, positions), 0).angleErrorMean, 0.2 * before);
}

TEST(AreaPreservingMap, DoesNotDependOnWhereTheShapeIs) {
  const Mesh mesh = noisyEllipsoid(5);
  const ClosedSurface surface = surfaceOf(mesh);
  const MappedSurface start = harmonicMap(surface);
  const Points reference = makeAreaPreserving(start).map.positions();
  for (const double scale : {1e-30, 0.01, 1e30}) {
    const ClosedSurface moved =
        surfaceOf(transformed(mesh, randomRotation(3), scale, scale * Vector3(30, -10, 5)));
    EXPECT_LT(
        (makeAreaPreserving(start.of(moved)).map.positions() - reference).cwiseAbs().maxCoeff(),
        1e-5);
  }
}

TEST(AreaPreservingMap, TurnsWithItsStart) {
  const ClosedSurface surface = surfaceOf(noisyEllipsoid(6));
  const MappedSurface start = harmonicMap(surface);
  const Points reference = makeAreaPreserving(start).map.positions();
  for (unsigned seed = 0; seed < 3; ++seed) {
    const Eigen::Matrix3d rotation = randomRotation(seed);
    const MappedSurface turned(surface, start.positions() * rotation.transpose());
    EXPECT_LT((makeAreaPreserving(turned).map.positions() - reference * rotation.transpose())
                  .cwiseAbs()
                  .maxCoeff(),
              1e-5);
  }
}

TEST(AreaPreservingMap, IsTheSameEveryTimeToTheLastBit) {
  const ClosedSurface surface = surfaceOf(noisyEllipsoid(7));
  const MappedSurface start = harmonicMap(surface);
  EXPECT_EQ(makeAreaPreserving(start).map.positions(), makeAreaPreserving(start).map.positions());
}

TEST(AreaPreservingMap, DoesNotDependOnTheNumbering) {
  const Mesh mesh = noisyEllipsoid(8);
  const ClosedSurface surface = surfaceOf(mesh);
  const MappedSurface start = harmonicMap(surface);
  const Points reference = makeAreaPreserving(start).map.positions();
  Random random(1);
  const auto shuffled = [&](Eigen::Index count) {
    std::vector<int> order(static_cast<size_t>(count));
    std::iota(order.begin(), order.end(), 0);
    for (size_t i = order.size(); i > 1; --i)
      std::swap(order[i - 1], order[random.index(static_cast<int>(i))]);
    return order;
  };
  const std::vector<int> vertexOrder = shuffled(mesh.vertices.rows()),
                         faceOrder = shuffled(mesh.faces.rows());
  Mesh renumbered = mesh;
  Points renumberedStart = start.positions();
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    renumbered.vertices.row(vertexOrder[v]) = mesh.vertices.row(v);
    renumberedStart.row(vertexOrder[v]) = start.positions().row(v);
  }
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      renumbered.faces(faceOrder[f], (k + static_cast<int>(f)) % 3) = vertexOrder[mesh.faces(f, k)];
  const ClosedSurface other = surfaceOf(renumbered);
  const Points result = makeAreaPreserving(MappedSurface(other, renumberedStart)).map.positions();
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
    EXPECT_LT((result.row(vertexOrder[v]) - reference.row(v)).norm(), 1e-5);
}

TEST(AreaPreservingMap, ReportsProgress) {
  const ClosedSurface surface = surfaceOf(noisyEllipsoid(9));
  double last = 0;
  makeAreaPreserving(harmonicMap(surface), {}, [&](double fraction) {
    EXPECT_GE(fraction, last);
    last = fraction;
  });
  EXPECT_EQ(last, 1);
}

TEST(AreaPreservingMap, RefusesAWeightOutsideItsRange) {
  const Mesh mesh = icosahedron();
  const ClosedSurface surface = surfaceOf(mesh);
  const MappedSurface start(surface, mesh.vertices);
  for (const double weight : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(makeAreaPreserving(start, {weight}), ParameterError);
}

}  // namespace
}  // namespace sphere_propagation::test
