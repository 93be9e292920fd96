// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/root_map/root_map.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tests/core/limb_meshes.h"
#include "tests/core/sizes.h"
#include "tests/core/test_meshes.h"
#include "vcg_ext/sphere/map_measures.h"

namespace sphere_propagation::test {
namespace {

const std::vector<InitialMap> starts{InitialMap::Automatic, InitialMap::Brechbuehler,
                                     InitialMap::Harmonic, InitialMap::Hierarchical};

struct NamedMesh {
  std::string name;
  Mesh mesh;
};

std::vector<NamedMesh> smallMeshes() {
  Mesh duplicate = octahedron(), folded = tetrahedron();
  duplicate.vertices.row(1) = duplicate.vertices.row(2);
  folded.vertices.row(1) = folded.vertices.row(2);
  return {{"4 vertices", tetrahedron()},
          {"4 vertices, long", stretched(tetrahedron(), 100, 1, 1)},
          {"4 vertices, flat", stretched(tetrahedron(), 1, 2, 0.01)},
          {"4 vertices, two of them one", folded},
          {"5 vertices", bipyramid(3)},
          {"5 vertices, long", stretched(bipyramid(3), 1, 1, 100)},
          {"5 vertices, flat", stretched(bipyramid(3), 1, 1, 0.01)},
          {"6 vertices", octahedron()},
          {"6 vertices, skewed", stretched(octahedron(), 100, 3, 1)},
          {"6 vertices, two of them one", duplicate},
          {"7 vertices", bipyramid(5)},
          {"zero-area face", withZeroAreaFace()},
          {"box of 8 vertices", box(1)},
          {"box of 8 vertices, long", stretched(box(1), 100, 1, 1)},
          {"box of 8 vertices, flat", stretched(box(1), 1, 1, 0.01)}};
}

std::vector<NamedMesh> stubbornMeshes() {
  Mesh collapsed = noisyEllipsoid(4);
  for (int f = 0; f < 60; ++f)  // a tenth of the vertices moved onto a neighbour
    collapsed.vertices.row(collapsed.faces(21 * f, 0)) =
        collapsed.vertices.row(collapsed.faces(21 * f, 1));
  return {{"flattened", ellipsoid(30, 20, 0, sizeFor(8, 4))},
          {"needle", ellipsoid(1000, 1, 1, sizeFor(8, 4))},
          {"duplicate vertices", collapsed},
          {"box", box(sizeFor(6, 3))},
          {"long box", stretched(box(sizeFor(6, 3)), 100, 1, 1)},
          {"flat box", stretched(box(sizeFor(6, 3)), 1, 1, 0.01)},
          {"long flat box", stretched(box(sizeFor(6, 3)), 100, 1, 0.01)},
          {"vertices of high valence", bipyramid(sizeFor(200, 50))},
          {"faces of very different sizes", rings(1e-6)},
          {"thin cup", cup(0.02, sizeFor(30, 16), sizeFor(12, 6))}};
}

TEST(RootMap, OfSmallAndStubbornMeshesFromEachStart) {
  std::vector<NamedMesh> meshes = smallMeshes();
  for (NamedMesh& mesh : stubbornMeshes()) meshes.push_back(std::move(mesh));
  for (const NamedMesh& named : meshes) {
    const ClosedSurface surface(named.mesh.vertices, named.mesh.faces, named.name);
    for (const InitialMap start : starts) {
      const RootMapResult result = makeRootMap(surface, {start, 0.9});  // valid by type
      EXPECT_NE(result.used, InitialMap::Automatic);
      const InitialMap asked = start == InitialMap::Automatic ? InitialMap::Hierarchical : start;
      EXPECT_EQ(result.failures.empty(), result.used == asked)
          << named.name << ": " << result.failures;
    }
  }
}

TEST(RootMap, PreservesAreasFromEachStart) {
  for (const NamedMesh& named :
       std::vector<NamedMesh>{{"ellipsoid", ellipsoid(30, 20, 15, sizeFor(12, 6))},
                              {"noisy ellipsoid", noisyEllipsoid(1)},
                              {"long ellipsoid", ellipsoid(60, 20, 15, sizeFor(12, 6))},
                              {"thick cup", cup(0.3, 24, 8)},
                              {"cup", cup(0.2, 40, 16)}}) {
    const ClosedSurface surface(named.mesh.vertices, named.mesh.faces, named.name);
    for (const InitialMap start : starts) {
      const RootMapResult result = makeRootMap(surface, {start, 0.9});
      const MapMeasures measures = measureMap(surface, result.map.positions());
      EXPECT_TRUE(measures.certificate.valid());
      EXPECT_LE(measures.areaRatioSd, 0.01) << named.name << " from " << nameOf(start);
      EXPECT_EQ(result.failures, "") << named.name;
      EXPECT_GT(result.steps, 0);
    }
  }
}

TEST(RootMap, PreservesAreasOfSmallMeshes) {
  for (const char* name :
       {"4 vertices", "5 vertices", "6 vertices", "6 vertices, skewed", "7 vertices"})
    for (const NamedMesh& named : smallMeshes())
      if (named.name == name) {
        const ClosedSurface surface(named.mesh.vertices, named.mesh.faces);
        EXPECT_LT(measureMap(surface, makeRootMap(surface).map.positions()).areaRatioSd, 1e-3)
            << name;
      }
}

TEST(RootMap, AllStartsEndAlike) {
  for (const Mesh& mesh : {noisyEllipsoid(2), ellipsoid(60, 20, 15, sizeFor(12, 6)),
                           cup(0.2, sizeFor(60, 40), sizeFor(24, 16))}) {
    const ClosedSurface surface(mesh.vertices, mesh.faces);
    const double automatic = measureMap(surface, makeRootMap(surface).map.positions()).areaRatioSd;
    for (const InitialMap start : {InitialMap::Brechbuehler, InitialMap::Harmonic}) {
      const RootMapResult result = makeRootMap(surface, {start, 0.9});
      EXPECT_EQ(result.used, start);
      EXPECT_NEAR(measureMap(surface, result.map.positions()).areaRatioSd / automatic, 1, 0.2)
          << nameOf(start) << ", automatic " << automatic << ", " << mesh.vertices.rows();
    }
  }
}

TEST(RootMap, AutomaticIsHierarchical) {
  const Mesh mesh = noisyEllipsoid(2);
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  const RootMapResult automatic = makeRootMap(surface);
  EXPECT_EQ(automatic.used, InitialMap::Hierarchical);
  EXPECT_EQ(automatic.map.positions(),
            makeRootMap(surface, {InitialMap::Hierarchical, 0.9}).map.positions());
  EXPECT_GT(automatic.levels, 3);
}

TEST(RootMap, WorksAtAnyScale) {
  const Mesh mesh = noisyEllipsoid(3);
  std::vector<double> scales{1e-100, 1e100, 1e-30, 1e-6, 1e30};
  scales.resize(static_cast<size_t>(sizeFor(5, 2)));
  for (const double scale : scales)
    for (const InitialMap start : starts) {
      const ClosedSurface surface(scale * mesh.vertices, mesh.faces);
      const MapMeasures measures =
          measureMap(surface, makeRootMap(surface, {start, 0.9}).map.positions());
      EXPECT_LT(measures.areaRatioSd, 0.01) << scale;
      EXPECT_LT(measures.angleErrorMean, 20) << scale;
    }
}

TEST(RootMap, SaysWhyItTookAnotherStart) {
  // All vertices of a tetrahedron are neighbours, so there is no place for Brechbuehler's poles.
  const Mesh mesh = tetrahedron();
  const RootMapResult result = makeRootMap(ClosedSurface(mesh.vertices, mesh.faces, "end-diastole"),
                                           {InitialMap::Brechbuehler, 0.9});
  EXPECT_EQ(result.used, InitialMap::Hierarchical);
  EXPECT_EQ(result.used, InitialMap::Hierarchical);
  EXPECT_NE(result.failures.find("Brechbuehler cannot be made valid (2 of 4 faces stay flipped)"),
            std::string::npos)
      << result.failures;
}

TEST(RootMap, FallsBackToTheHierarchicalStartForLimbs) {
  // Sizes fall exponentially along a limb: with four of them, whatever the poles, some end below
  // what can be told from a point.
  const Mesh mesh = tetrapod(80);
  const ClosedSurface surface(mesh.vertices, mesh.faces, "four limbs");
  for (const InitialMap start : {InitialMap::Brechbuehler, InitialMap::Harmonic}) {
    const RootMapResult result = makeRootMap(surface, {start, 0.9});
    EXPECT_EQ(result.used, InitialMap::Hierarchical);
    EXPECT_NE(result.failures.find(nameOf(start) + " cannot be made valid"), std::string::npos)
        << result.failures;
    EXPECT_NE(result.failures.find("of 1924 faces stay flipped"), std::string::npos)
        << result.failures;
  }
}

TEST(RootMap, OfLimbsBranchesSheetsAndCoils) {
  for (const NamedMesh& named :
       std::vector<NamedMesh>{{"limbs", limbs(sizeFor(10, 4), 1)},
                              {"bare limbs", tetrapod(sizeFor(80, 20))},
                              {"tree", tree(2, sizeFor(4, 2), 1)},
                              {"disc", disc(sizeFor(16, 8))},
                              {"coil", coil(2, 12, 80)},
                              {"branches on branches", tree(sizeFor(4, 3), 3, sizeFor(1, 0))}}) {
    const ClosedSurface surface(named.mesh.vertices, named.mesh.faces, named.name);
    const RootMapResult result = makeRootMap(surface);  // valid by type
    EXPECT_EQ(result.failures, "") << named.name;
    EXPECT_LT(measureMap(surface, result.map.positions()).areaRatioSd, 0.05) << named.name;
  }
}

/// A blob of 642 vertices and what scans, label images and careless tools make of it.
std::vector<NamedMesh> spoiltMeshes() {
  const Mesh smooth = blob(8, 0, 3);
  std::vector<NamedMesh> meshes{{"noise of 0.7 edge lengths", blob(8, 0.7, 3)},
                                {"stretched by 100", stretched(smooth, 100, 1, 1)},
                                {"flattened", stretched(smooth, 1, 1, 1e-12)},
                                {"tiny", stretched(smooth, 1e-30, 1e-30, 1e-30)},
                                {"huge", stretched(smooth, 1e30, 1e30, 1e30)}};
  Mesh coarse = smooth;
  coarse.vertices = (coarse.vertices.array() * 4).round() / 4;
  meshes.push_back({"on a coarse grid", coarse});
  Mesh asFloat = smooth;
  asFloat.vertices = (1e-30 * smooth.vertices).cast<float>().cast<double>();
  meshes.push_back({"tiny, stored as float", asFloat});
  Mesh split =
      smooth;  // every tenth face is cut at the middle of an edge, so that a face there has no area
  const Eigen::Index faces = smooth.faces.rows(), vertices = smooth.vertices.rows(),
                     cuts = faces / 10;
  split.vertices.conservativeResize(vertices + cuts, 3);
  split.faces.conservativeResize(faces + 2 * cuts, 3);
  for (Eigen::Index i = 0; i < cuts; ++i) {
    const Eigen::RowVector3i f = smooth.faces.row(10 * i);
    const int middle = static_cast<int>(vertices + i);
    split.vertices.row(middle) = 0.5 * (smooth.vertices.row(f[0]) + smooth.vertices.row(f[1]));
    split.faces.row(10 * i) << f[0], f[1], middle;  // no area
    split.faces.row(faces + 2 * i) << f[1], f[2], middle;
    split.faces.row(faces + 2 * i + 1) << f[2], f[0], middle;
  }
  meshes.push_back({"faces without area", split});
  return meshes;
}

TEST(RootMap, OfSpoiltMeshes) {
  for (const NamedMesh& named : spoiltMeshes()) {
    const ClosedSurface surface(named.mesh.vertices, named.mesh.faces, named.name);
    const RootMapResult result = makeRootMap(surface);  // valid by type
    EXPECT_EQ(result.failures, "") << named.name;
    const MapMeasures measures = measureMap(surface, result.map.positions());
    EXPECT_TRUE(measures.certificate.valid()) << named.name;
    EXPECT_LT(measures.areaRatioSd, 0.1) << named.name;
    EXPECT_LT(measures.areaLogMean, 0.1) << named.name;
  }
}

TEST(RootMap, RefusesAWeightOutsideItsRange) {
  const Mesh mesh = icosahedron();
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  for (const double weight : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(makeRootMap(surface, {InitialMap::Automatic, weight}), ParameterError);
}

TEST(RootMap, RefusesANegativeNumberOfThreads) {
  const Mesh mesh = icosahedron();
  EXPECT_THROW(
      makeRootMap(ClosedSurface(mesh.vertices, mesh.faces), {InitialMap::Automatic, 0.9, -1}),
      ParameterError);
}

TEST(RootMap, ReportsProgress) {
  const Mesh mesh = noisyEllipsoid(1);
  for (const InitialMap start : starts) {
    double last = 0;
    int calls = 0;
    makeRootMap(ClosedSurface(mesh.vertices, mesh.faces), {start, 0.9}, [&](double fraction) {
      EXPECT_GE(fraction, last);
      last = fraction;
      ++calls;
    });
    EXPECT_EQ(last, 1) << nameOf(start);
    EXPECT_GT(calls, 4) << nameOf(start);
  }
}

}  // namespace
}  // namespace sphere_propagation::test
