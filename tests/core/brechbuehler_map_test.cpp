// SPDX-License-Identifier: GPL-3.0-only
// Every equation of C. Brechbuehler, G. Gerig, O. Kuebler (1995) against the mesh itself.

#include "vcg_ext/root_map/brechbuehler_map.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "tests/core/test_meshes.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation {
namespace {

using test::pi;

bool isPole(const Poles& poles, int v) { return v == poles.north || v == poles.south; }

/// What longitudes miss by on the way from v to w: 2 pi when one walks eastward over the date line,
/// -2 pi westward.
double jump(const DateLine& line, int v, int w) {
  double sum = 0;
  for (const auto& [here, west] : line.crossings) {
    if (v == west && w == here) sum += 2 * pi;
    if (v == here && w == west) sum -= 2 * pi;
  }
  return sum;
}

/// The shapes that the equations are checked on: round, long, noisy, with a zero-area face, the
/// smallest.
std::vector<ClosedSurface> shapes() {
  return {surfaceOf(test::ellipsoid(30, 20, 15)), surfaceOf(test::ellipsoid(100, 5, 4)),
          surfaceOf(test::noisyEllipsoid(3)),     surfaceOf(test::withZeroAreaFace()),
          surfaceOf(test::icosahedron()),         surfaceOf(test::bipyramid(7))};
}

TEST(ExtremePoles, LieAtTheEndsOfTheLongestAxis) {
  test::Mesh mesh = test::ellipsoid(3, 2, 1);
  int last = 0, first = 0;
  for (int v = 0; v < mesh.vertices.rows(); ++v) {
    if (mesh.vertices(v, 0) > mesh.vertices(last, 0)) last = v;
    if (mesh.vertices(v, 0) < mesh.vertices(first, 0)) first = v;
  }
  const Poles poles = extremePoles(surfaceOf(mesh));
  EXPECT_NEAR(mesh.vertices(poles.north, 0), mesh.vertices(last, 0), 1e-9);
  EXPECT_NEAR(mesh.vertices(poles.south, 0), mesh.vertices(first, 0), 1e-9);
}

TEST(ExtremePoles, TurnAndScaleWithTheShape) {
  const test::Mesh mesh = test::noisyEllipsoid(5);
  const Poles poles = extremePoles(surfaceOf(mesh));
  EXPECT_NE(poles.north, poles.south);
  for (unsigned seed = 0; seed < 10; ++seed)
    for (const double scale : {1e-120, 0.01, 1.0, 1e120}) {
      const Poles turned = extremePoles(surfaceOf(
          test::transformed(mesh, test::randomRotation(seed), scale, scale * Vector3(3, -2, 5))));
      EXPECT_EQ(turned.north, poles.north);
      EXPECT_EQ(turned.south, poles.south);
    }
}

TEST(ExtremePoles, AreTheSmallestIndicesOfEqualOnes) {
  // A prism with square ends, turned into no axis: four vertices are equally far out on each side.
  const test::Mesh box = {(Points(8, 3) << -3, -1, -1, -3, 1, -1, -3, 1, 1, -3, -1, 1, 3, -1, -1, 3,
                           1, -1, 3, 1, 1, 3, -1, 1)
                              .finished(),
                          (Triangles(12, 3) << 0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                           1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7)
                              .finished()};
  const Poles poles = extremePoles(surfaceOf(box));
  EXPECT_EQ(poles.north, 4);
  EXPECT_EQ(poles.south, 0);
}

TEST(Colatitudes, OfAnOctahedronAndBipyramidsByHand) {
  for (const int sides : {3, 4, 5, 12}) {
    const ClosedSurface surface = surfaceOf(test::bipyramid(sides));
    const Eigen::VectorXd colatitude = colatitudes(surface, {0, 1});
    EXPECT_EQ(colatitude[0], 0);
    EXPECT_EQ(colatitude[1], pi);
    for (int v = 2; v < surface.vertexCount(); ++v) EXPECT_NEAR(colatitude[v], pi / 2, 1e-14);
  }
}

TEST(Colatitudes, AreTheMeanOfTheNeighboursAndLieBetweenThePoles) {
  for (const ClosedSurface& surface : shapes()) {
    const Poles poles = extremePoles(surface);
    const Eigen::VectorXd colatitude = colatitudes(surface, poles);
    for (int v = 0; v < surface.vertexCount(); ++v) {
      if (isPole(poles, v)) continue;
      double residual = surface.ring(v).size() * colatitude[v];
      for (int w : surface.ring(v)) residual -= colatitude[w];
      EXPECT_NEAR(residual, 0, 1e-11);
      EXPECT_GT(colatitude[v], 0);
      EXPECT_LT(colatitude[v], pi);
    }
  }
}

TEST(DateLine, IsTheSteepestPathAndItsPairsLieToTheWest) {
  for (const ClosedSurface& surface : shapes()) {
    const Poles poles = extremePoles(surface);
    const Eigen::VectorXd colatitude = colatitudes(surface, poles);
    const DateLine line = dateLine(surface, poles, colatitude);
    ASSERT_GE(line.path.size(), 3u);
    EXPECT_EQ(line.path.front(), poles.north);
    EXPECT_EQ(line.path.back(), poles.south);
    for (size_t k = 0; k + 1 < line.path.size(); ++k)
      for (int w : surface.ring(line.path[k]))
        EXPECT_LE(colatitude[w], colatitude[line.path[k + 1]]);
    EXPECT_EQ(std::set<int>(line.path.begin(), line.path.end()).size(), line.path.size());
    const Eigen::VectorXd longitude = longitudes(surface, poles, line);
    for (const auto& [here, west] : line.crossings) {
      EXPECT_TRUE(std::find(line.path.begin(), line.path.end(), here) != line.path.end());
      EXPECT_FALSE(isPole(poles, west));
      EXPECT_GT(longitude[west], longitude[here]);  // just below 2 pi, against just above 0
    }
  }
}

TEST(DateLine, GoesOnWhereColatitudesHaveAPeak) {
  const ClosedSurface surface = surfaceOf(test::ellipsoid(30, 20, 15));
  const Poles poles = extremePoles(surface);
  const Points reference = brechbuehlerPositions(surface, poles);
  const Eigen::VectorXd colatitude = colatitudes(surface, poles);
  Eigen::VectorXd peaked = colatitude;
  peaked[dateLine(surface, poles, colatitude).path[4]] = 3.1;
  const DateLine line = dateLine(surface, poles, peaked);
  ASSERT_EQ(line.path.front(), poles.north);
  ASSERT_EQ(line.path.back(), poles.south);
  // Another line, the same longitudes but for whole turns and the anchor.
  const Eigen::VectorXd longitude = longitudes(surface, poles, line);
  double offset = 0;
  for (int v = 0; v < surface.vertexCount(); ++v) {
    if (isPole(poles, v)) continue;
    const double difference = longitude[v] - std::atan2(reference(v, 1), reference(v, 0));
    if (v == 0 || (v == 1 && isPole(poles, 0))) offset = difference;
    EXPECT_NEAR(std::remainder(difference - offset, 2 * pi), 0, 1e-10);
  }
  // Flat colatitudes are a plateau everywhere: the line still arrives.
  EXPECT_EQ(dateLine(surface, poles, Eigen::VectorXd::Zero(surface.vertexCount())).path.back(),
            poles.south);
}

TEST(DateLine, JumpsByOneTurnRoundAPoleAndByNoneRoundAnyOtherVertex) {
  for (const ClosedSurface& surface : shapes()) {
    const Poles poles = extremePoles(surface);
    const DateLine line = dateLine(surface, poles, colatitudes(surface, poles));
    for (int v = 0; v < surface.vertexCount(); ++v) {
      const IndexRange ring = surface.ring(v);
      double around = 0;
      bool meetsPole = false;
      for (int i = 0; i < ring.size(); ++i) {
        around += jump(line, ring[i], ring[(i + 1) % ring.size()]);
        meetsPole = meetsPole || isPole(poles, ring[i]);
      }
      if (meetsPole) continue;  // a ring through a pole says nothing: longitude has no value there
      const double expected = v == poles.north ? 2 * pi : v == poles.south ? -2 * pi : 0;
      EXPECT_NEAR(around, expected, 1e-12) << "ring of vertex " << v;
    }
  }
}

TEST(Longitudes, OfAnOctahedronAndBipyramidsByHand) {
  for (const int sides : {3, 4, 5, 12}) {
    const ClosedSurface surface = surfaceOf(test::bipyramid(sides));
    const Poles poles{0, 1};
    const DateLine line = dateLine(surface, poles, colatitudes(surface, poles));
    const Eigen::VectorXd longitude = longitudes(surface, poles, line);
    // Round the north pole, counter-clockwise seen from outside, from the anchor on.
    const IndexRange ring = surface.ring(0);
    int start = 0;
    while (ring[start] != line.path[1]) ++start;
    for (int i = 0; i < sides; ++i)
      EXPECT_NEAR(longitude[ring[(start + i) % sides]], 2 * pi * i / sides, 1e-13);
  }
}

TEST(Longitudes, AreTheMeanOfTheNeighboursAcrossTheDateLine) {
  for (const ClosedSurface& surface : shapes()) {
    const Poles poles = extremePoles(surface);
    const DateLine line = dateLine(surface, poles, colatitudes(surface, poles));
    const Eigen::VectorXd longitude = longitudes(surface, poles, line);
    EXPECT_NEAR(longitude[line.path[1]], 0, 1e-11);
    for (int v = 0; v < surface.vertexCount(); ++v) {
      if (isPole(poles, v)) {
        EXPECT_EQ(longitude[v], 0);
        continue;
      }
      // As seen from v, the longitude of a neighbour across the line is a turn more or less.
      double residual = 0;
      for (int w : surface.ring(v))
        if (!isPole(poles, w)) residual += longitude[v] - (longitude[w] + jump(line, v, w));
      EXPECT_NEAR(residual, 0, 1e-10) << "vertex " << v;
    }
  }
}

TEST(BrechbuehlerMap, IsOnTheSphereWithThePolesInPlace) {
  for (const ClosedSurface& surface : shapes()) {
    const Poles poles = extremePoles(surface);
    const Points positions = brechbuehlerPositions(surface);
    EXPECT_LT((positions.rowwise().norm().array() - 1).abs().maxCoeff(), 1e-14);
    EXPECT_LT((positions.row(poles.north) - Vector3(0, 0, 1).transpose()).norm(), 1e-15);
    EXPECT_LT((positions.row(poles.south) - Vector3(0, 0, -1).transpose()).norm(), 1e-15);
  }
}

TEST(BrechbuehlerMap, PreservesOrientation) {
  for (const test::Mesh& mesh :
       {test::ellipsoid(30, 20, 15), test::octahedron(), test::bipyramid(5), test::icosahedron()}) {
    const Certificate certificate = certify(mesh.faces, brechbuehlerPositions(surfaceOf(mesh)));
    EXPECT_TRUE(certificate.valid()) << certificate.reason();
    EXPECT_NEAR(certificate.degree, 1, 1e-12);
  }
}

TEST(BrechbuehlerMap, HasDegreeOneBetweenAnyPoles) {
  const ClosedSurface surface = surfaceOf(test::ellipsoid(30, 20, 15, 4));
  for (int north = 0; north < surface.vertexCount(); north += 7)
    for (int south = 3; south < surface.vertexCount(); south += 11) {
      const IndexRange ring = surface.ring(north);
      if (north == south || std::find(ring.begin(), ring.end(), south) != ring.end()) continue;
      const Points positions = brechbuehlerPositions(surface, {north, south});
      EXPECT_NEAR(certify(surface.faces(), positions).degree, 1, 1e-9) << north << " " << south;
    }
}

TEST(BrechbuehlerMap, LeavesRoomBetweenNeighbourPoles) {
  const ClosedSurface surface = surfaceOf(test::tetrahedron());
  const int north = 0, south = surface.ring(0)[0];
  const DateLine line = dateLine(surface, {north, south}, colatitudes(surface, {north, south}));
  ASSERT_EQ(line.path.size(), 2u);
  ASSERT_EQ(line.crossings.size(), 1u);
  const Eigen::VectorXd longitude = longitudes(surface, {north, south}, line);
  // The two others have one edge between them and one across the poles' edge: half a turn each.
  EXPECT_NEAR(std::fabs(longitude[line.crossings[0][0]] - longitude[line.crossings[0][1]]), pi,
              1e-13);
}

TEST(BrechbuehlerMap, IsTheSameForATurnedAndScaledShape) {
  const test::Mesh mesh = test::noisyEllipsoid(11);
  const Points reference = brechbuehlerPositions(surfaceOf(mesh));
  for (unsigned seed = 0; seed < 3; ++seed) {
    const Points positions = brechbuehlerPositions(
        surfaceOf(test::transformed(mesh, test::randomRotation(seed), 0.37, {100, -50, 20})));
    EXPECT_LT((positions - reference).rowwise().norm().maxCoeff(), 1e-12);
  }
}

TEST(BrechbuehlerMap, RefusesPolesThatAreNone) {
  const ClosedSurface surface = surfaceOf(test::octahedron());
  for (const Poles& poles : {Poles{0, 0}, Poles{-1, 2}, Poles{0, 6}}) {
    EXPECT_THROW(colatitudes(surface, poles), ParameterError);
    EXPECT_THROW(dateLine(surface, poles, Eigen::VectorXd::Zero(6)), ParameterError);
    EXPECT_THROW(longitudes(surface, poles, {}), ParameterError);
    EXPECT_THROW(brechbuehlerPositions(surface, poles), ParameterError);
  }
}

}  // namespace
}  // namespace sphere_propagation
