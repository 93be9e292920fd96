// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/map_measures.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/test_meshes.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation::test {
namespace {

TEST(MapMeasures, IdentityOfARegularSolid) {
  for (const Mesh& mesh : {tetrahedron(), octahedron(), icosahedron()}) {
    const MapMeasures measures =
        measureMap(ClosedSurface(mesh.vertices, mesh.faces), mesh.vertices);
    EXPECT_TRUE(measures.certificate.valid());
    EXPECT_NEAR(measures.areaRatioSd, 0, 1e-14);
    EXPECT_NEAR(measures.areaLogMean, 0, 1e-14);
    EXPECT_NEAR(measures.angleErrorMean, 0, 1e-12);
  }
}

TEST(MapMeasures, AreasByHand) {
  // Half lunes of 60 and 120 degrees: their solid angle is their longitude. All faces of the
  // octahedron are an eighth.
  const Mesh mesh = bipyramid(4);
  Points positions = mesh.vertices;
  const double longitudes[4] = {0, pi / 3, pi, pi + pi / 3};
  for (int i = 0; i < 4; ++i)
    positions.row(2 + i) << std::cos(longitudes[i]), std::sin(longitudes[i]), 0;
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  const Eigen::VectorXd ratios = areaRatios(surface, positions);
  for (int f = 0; f < 8; ++f) EXPECT_NEAR(ratios[f], f / 2 % 2 == 0 ? 2.0 / 3 : 4.0 / 3, 1e-14);
  const MapMeasures measures = measureMap(surface, positions);
  EXPECT_NEAR(measures.areaRatioSd, 1.0 / 3, 1e-14);
  EXPECT_NEAR(measures.areaLogMean, (std::log(1.5) + std::log(4.0 / 3)) / 2, 1e-14);
}

TEST(MapMeasures, AnglesByHand) {
  // A stretched octahedron on the regular one: apex angle t with cos t = h^2 / (1 + h^2) in place
  // of 60 degrees, and the two base angles off by half as much each.
  for (const double h : {0.2, 1.0, 3.0}) {
    Mesh mesh = octahedron();
    const Points positions = mesh.vertices;
    mesh.vertices.col(2) *= h;
    const MapMeasures measures = measureMap(ClosedSurface(mesh.vertices, mesh.faces), positions);
    const double apex = std::acos(h * h / (1 + h * h)) * 180 / pi;
    EXPECT_NEAR(measures.angleErrorMean, 2 * std::fabs(apex - 60) / 3, 1e-11);
    EXPECT_NEAR(measures.areaRatioSd, 0, 1e-14);
  }
}

/// An irregular octahedron and an irregular map of it; the figures below are those of an
/// independent implementation (NumPy).
Mesh irregular() {
  Mesh mesh = octahedron();
  mesh.vertices.row(0) *= 2;
  mesh.vertices.row(4) *= 3;
  return mesh;
}

Points irregularMap() {
  Points positions = octahedron().vertices;
  positions.row(3) << 0.6, -0.8, 0;
  positions.row(5) << 0, 0.6, -0.8;
  return positions;
}

TEST(MapMeasures, AgreesWithAnIndependentImplementation) {
  const Mesh mesh = irregular();
  const MapMeasures measures = measureMap(ClosedSurface(mesh.vertices, mesh.faces), irregularMap());
  EXPECT_TRUE(measures.certificate.valid());
  EXPECT_NEAR(measures.areaRatioSd, 1.4022711248884239, 1e-12);
  EXPECT_NEAR(measures.areaLogMean, 0.5325334648974429, 1e-12);
  EXPECT_NEAR(measures.angleErrorMean, 17.71830815474875, 1e-10);
}

TEST(MapMeasures, TinyFacesHaveNoRatio) {
  // Face 0 split at a point 1e-7 from its edge: its sliver has an area below 1e-5 of the mean.
  Mesh mesh = irregular();
  mesh.vertices.conservativeResize(7, 3);
  mesh.vertices.row(6) << 1, 0.5, 1e-7;
  mesh.faces.conservativeResize(10, 3);
  mesh.faces.row(0) << 0, 2, 6;
  mesh.faces.row(8) << 2, 4, 6;
  mesh.faces.row(9) << 4, 0, 6;
  Points positions = irregularMap();
  positions.conservativeResize(7, 3);
  positions.row(6) = Eigen::RowVector3d(0.7, 0.7, 0.14).normalized();
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  EXPECT_EQ(areaRatios(surface, positions)[0], 1);
  EXPECT_NE(areaRatios(surface, positions)[8], 1);
  const MapMeasures measures = measureMap(surface, positions);
  EXPECT_NEAR(measures.areaRatioSd, 1.3525385366125287, 1e-12);
  EXPECT_NEAR(measures.areaLogMean, 0.5520441324404619, 1e-12);
  EXPECT_NEAR(measures.angleErrorMean, 16.829295491182528, 1e-10);
}

TEST(MapMeasures, RatiosOfVerticesByHand) {
  // The half lunes of above: a vertex of the equator has two faces on each side of it, a pole has
  // all of its half.
  const Mesh mesh = bipyramid(4);
  Points positions = mesh.vertices;
  const double longitudes[4] = {0, pi / 3, pi, pi + pi / 3};
  for (int i = 0; i < 4; ++i)
    positions.row(2 + i) << std::cos(longitudes[i]), std::sin(longitudes[i]), 0;
  EXPECT_TRUE(vertexAreaRatios(ClosedSurface(mesh.vertices, mesh.faces), positions)
                  .isApproxToConstant(1, 1e-14));

  // Whatever the map: areas add up to those of the sphere, each face counted at its three corners.
  const Mesh other = irregular();
  const ClosedSurface surface(other.vertices, other.faces);
  const Eigen::VectorXd ratios = vertexAreaRatios(surface, irregularMap());
  const Eigen::VectorXd areas = vertexAreas(other.vertices, other.faces);
  EXPECT_NEAR(ratios.dot(areas) / areas.sum(), 1, 1e-14);
  EXPECT_GT(ratios.maxCoeff() - ratios.minCoeff(), 0.1);
  // The first vertex: its four faces.
  const Eigen::VectorXd faces = areaRatios(surface, irregularMap());
  const Eigen::VectorXd sizes = faceAreas(other.vertices, other.faces);
  double onSphere = 0, onSurface = 0;
  for (int f = 0; f < surface.faceCount(); ++f)
    if ((other.faces.row(f).array() == 0).any()) {
      onSphere += faces[f] * sizes[f];
      onSurface += sizes[f];
    }
  EXPECT_NEAR(ratios[0], onSphere / onSurface, 1e-14);
}

TEST(MapMeasures, AnInvalidMapIsMeasuredToo) {
  const Mesh mesh = octahedron();
  const MapMeasures measures = measureMap(ClosedSurface(mesh.vertices, mesh.faces), -mesh.vertices);
  EXPECT_EQ(measures.certificate.flippedFaces, 8);
  EXPECT_NEAR(measures.areaLogMean, std::log(1e12), 1e-9);  // ratios below 1e-12 are taken as 1e-12
  EXPECT_TRUE(std::isfinite(measures.areaRatioSd));
}

TEST(MapMeasures, ScaleAndPlaceDoNotMatter) {
  const Mesh mesh = irregular(), moved = transformed(mesh, randomRotation(3), 1e4, {5e4, 0, -2e4});
  const MapMeasures a = measureMap(ClosedSurface(mesh.vertices, mesh.faces), irregularMap());
  const MapMeasures b =
      measureMap(ClosedSurface(moved.vertices, moved.faces), irregularMap() * randomRotation(8));
  EXPECT_NEAR(a.areaRatioSd, b.areaRatioSd, 1e-12);
  EXPECT_NEAR(a.areaLogMean, b.areaLogMean, 1e-12);
  EXPECT_NEAR(a.angleErrorMean, b.angleErrorMean, 1e-10);
}

}  // namespace
}  // namespace sphere_propagation::test
