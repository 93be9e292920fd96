// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/preparation/surface_preparation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/core/sizes.h"
#include "tests/core/test_meshes.h"
#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation::test {
namespace {

PreparedMesh prepared(const Mesh& mesh, const PreparationParameters& parameters = {}) {
  return preparedMesh(mesh.vertices, mesh.faces, parameters, "heart");
}

/// Whether it is a closed surface now, with outward faces.
/// Nothing is wrong with it but that it encloses nothing.
bool isClosedThoughFlat(const PreparedMesh& mesh) {
  return mesh.left && mesh.left->fault == Fault::Flat;
}

testing::AssertionResult isClosed(const PreparedMesh& mesh) {
  if (mesh.left) return testing::AssertionFailure() << statement(*mesh.left);
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  if (enclosedVolume(mesh.vertices, mesh.faces) <= 0)
    return testing::AssertionFailure() << "inward";
  return testing::AssertionSuccess();
}

/// Without the faces for which `drop` says so of their centre; vertices stay.
Mesh without(Mesh mesh, const std::function<bool(const Vector3&)>& drop) {
  Triangles kept(mesh.faces.rows(), 3);
  Eigen::Index count = 0;
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    Vector3 centre = Vector3::Zero();
    for (int k = 0; k < 3; ++k) centre += mesh.vertices.row(mesh.faces(f, k)).transpose() / 3;
    if (!drop(centre)) kept.row(count++) = mesh.faces.row(f);
  }
  mesh.faces = kept.topRows(count);
  return mesh;
}

Mesh both(const Mesh& a, const Mesh& b) {
  Mesh mesh{Points(a.vertices.rows() + b.vertices.rows(), 3),
            Triangles(a.faces.rows() + b.faces.rows(), 3)};
  mesh.vertices << a.vertices, b.vertices;
  mesh.faces << a.faces, b.faces.array() + static_cast<int>(a.vertices.rows());
  return mesh;
}

Mesh moved(Mesh mesh, double x, double y, double z) {
  mesh.vertices.rowwise() += Eigen::RowVector3d(x, y, z);
  return mesh;
}

Mesh withFaces(Mesh mesh, const std::vector<std::array<int, 3>>& more) {
  Triangles faces(mesh.faces.rows() + static_cast<Eigen::Index>(more.size()), 3);
  faces.topRows(mesh.faces.rows()) = mesh.faces;
  for (size_t i = 0; i < more.size(); ++i)
    faces.row(mesh.faces.rows() + static_cast<Eigen::Index>(i)) << more[i][0], more[i][1],
        more[i][2];
  mesh.faces = faces;
  return mesh;
}

/// Every face with three vertices of its own.
Mesh soup(const Mesh& mesh) {
  Mesh result{Points(3 * mesh.faces.rows(), 3), Triangles(mesh.faces.rows(), 3)};
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      result.vertices.row(3 * f + k) = mesh.vertices.row(mesh.faces(f, k));
      result.faces(f, k) = static_cast<int>(3 * f + k);
    }
  return result;
}

/// A sphere cut off at the height z, where the nodes lie on it exactly: n round, rows below.
Mesh bowl(double z, int around, int rows) {
  Mesh mesh{Points(around * rows + 1, 3), Triangles(around * (2 * rows - 1), 3)};
  const double end = std::acos(z);
  for (int r = 0; r < rows; ++r)
    for (int i = 0; i < around; ++i) {
      const double t = end + (pi - end) * r / rows, p = 2 * pi * (i + 0.5 * r) / around;
      mesh.vertices.row(r * around + i) << std::sin(t) * std::cos(p), std::sin(t) * std::sin(p),
          std::cos(t);
    }
  mesh.vertices.row(around * rows) << 0, 0, -1;
  Eigen::Index f = 0;
  for (int r = 0; r < rows; ++r)
    for (int i = 0; i < around; ++i) {
      const int a = r * around + i, b = r * around + (i + 1) % around;
      if (r + 1 == rows) {
        mesh.faces.row(f++) << a, around * rows, b;
        continue;
      }
      const int c = a + around, d = b + around;
      mesh.faces.row(f++) << a, c, b;
      mesh.faces.row(f++) << b, c, d;
    }
  return mesh;
}

/// The part below a height, faces that cross it being cut there.
Mesh cutBelow(const Mesh& mesh, double height) {
  std::vector<Vector3> points;
  std::vector<std::array<int, 3>> faces;
  std::map<std::pair<int, int>, int> cuts;
  std::vector<int> now(static_cast<size_t>(mesh.vertices.rows()), -1);
  const auto above = [&](int v) { return mesh.vertices(v, 2) - height; };
  const auto place = [&](int v) {
    if (now[v] < 0) {
      now[v] = static_cast<int>(points.size());
      points.emplace_back(mesh.vertices.row(v).transpose());
    }
    return now[v];
  };
  const auto cut = [&](int a, int b) {
    if (a > b) std::swap(a, b);
    const auto [entry, isNew] = cuts.insert({{a, b}, static_cast<int>(points.size())});
    if (isNew) {
      const double t = above(a) / (above(a) - above(b));
      const Eigen::RowVector3d p = (1 - t) * mesh.vertices.row(a) + t * mesh.vertices.row(b);
      points.emplace_back(p.transpose());
    }
    return entry->second;
  };
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    std::vector<int> polygon;
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.faces(f, k), b = mesh.faces(f, (k + 1) % 3);
      if (above(a) < 0) polygon.push_back(place(a));
      if ((above(a) < 0) != (above(b) < 0)) polygon.push_back(cut(a, b));
    }
    for (size_t k = 2; k < polygon.size(); ++k)
      faces.push_back({polygon[0], polygon[k - 1], polygon[k]});
  }
  Mesh result{Points(static_cast<Eigen::Index>(points.size()), 3), Triangles(0, 3)};
  for (size_t v = 0; v < points.size(); ++v)
    result.vertices.row(static_cast<Eigen::Index>(v)) = points[v].transpose();
  return withFaces(result, faces);
}

/// A strip that comes back to itself with a half turn.
Mesh moebiusStrip() {
  constexpr int around = 60;
  Mesh mesh{Points(2 * around, 3), Triangles(2 * around, 3)};
  for (int i = 0; i < around; ++i) {
    const double t = 2 * pi * i / around;
    for (const int side : {0, 1}) {
      const double w = side == 0 ? -0.3 : 0.3, r = 1 + w * std::cos(t / 2);
      mesh.vertices.row(2 * i + side) << r * std::cos(t), r * std::sin(t), w * std::sin(t / 2);
    }
    const int j = (i + 1) % around, turn = j == 0 ? 1 : 0;
    mesh.faces.row(2 * i) << 2 * i, 2 * j + turn, 2 * i + 1;
    mesh.faces.row(2 * i + 1) << 2 * i + 1, 2 * j + turn, 2 * j + 1 - turn;
  }
  return mesh;
}

TEST(SurfacePreparation, LeavesAClosedSurfaceAlone) {
  for (const Mesh& mesh : {tetrahedron(), icosphereMesh(5), box(3), tetrapod(4)}) {
    const PreparedMesh result = prepared(mesh);
    EXPECT_FALSE(result.changed);
    EXPECT_EQ(result.vertices, mesh.vertices);
    EXPECT_EQ(result.faces, mesh.faces);
    EXPECT_TRUE(isClosed(result));
  }
}

TEST(SurfacePreparation, WeldsSplitVertices) {
  for (const Mesh& mesh : {icosphereMesh(4), box(3), cup(0.01, 24, 12)}) {
    const PreparedMesh result = prepared(soup(mesh));
    EXPECT_TRUE(isClosed(result));
    EXPECT_EQ(result.vertices.rows(), mesh.vertices.rows());
    EXPECT_EQ(result.weldedVertices, 3 * mesh.faces.rows() - mesh.vertices.rows());
    EXPECT_TRUE(result.openings.empty());
  }
}

TEST(SurfacePreparation, WeldsWhatSinglePrecisionKeepsApart) {
  Mesh mesh = soup(moved(icosphereMesh(6), 900, -700, 400));
  Random random(1);
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
    for (int k = 0; k < 3; ++k) mesh.vertices(v, k) += random.uniform(-3e-5, 3e-5);
  EXPECT_TRUE(isClosed(prepared(mesh)));
  EXPECT_EQ(prepared(mesh).vertices.rows(), 362);
}

TEST(SurfacePreparation, KeepsTheSidesOfAThinWallApart) {
  const Mesh thin = stretched(box(4), 1, 1, 1e-9);  // far below the tolerance
  int seen = 0;
  const PreparedMesh result = prepared(without(
      thin, [&seen](const Vector3& c) { return c.z() > 0.9e-9 && c.x() > 0.3 && ++seen == 1; }));
  EXPECT_TRUE(isClosedThoughFlat(result));
  EXPECT_EQ(result.weldedVertices, 0);
}

TEST(SurfacePreparation, LeavesAClosedSheetFlat) {
  // One side of a plane: its lid lies in it, too.
  const Mesh sheet = without(box(4), [](const Vector3& c) { return c.z() < 0.99; });
  const PreparedMesh result = prepared(sheet);
  EXPECT_EQ(result.openings.size(), 1u);
  EXPECT_TRUE(isClosedThoughFlat(result));
}

TEST(SurfacePreparation, DropsWhatIsThereTwice) {
  Mesh mesh = icosphereMesh(3);
  std::vector<std::array<int, 3>> again;
  for (int f = 0; f < 40; ++f)
    again.push_back({mesh.faces(f, 1), mesh.faces(f, 0), mesh.faces(f, 2)});
  again.push_back({4, 4, 7});
  const PreparedMesh result = prepared(withFaces(mesh, again));
  EXPECT_TRUE(isClosed(result));
  EXPECT_EQ(result.duplicateFaces, 41);
  EXPECT_EQ(result.faces, mesh.faces);
}

TEST(SurfacePreparation, TakesASecondCopyOfEverythingAway) {
  const Mesh mesh = icosphereMesh(3);
  EXPECT_EQ(prepared(soup(both(mesh, mesh))).faces.rows(), mesh.faces.rows());
  EXPECT_TRUE(isClosed(prepared(both(mesh, mesh))));
}

TEST(SurfacePreparation, MendsFacesWithoutArea) {
  const PreparedMesh result = prepared(withZeroAreaFace());
  EXPECT_TRUE(result.changed);
  EXPECT_TRUE(isClosed(result));
  EXPECT_EQ(result.flatFaces, 1);
  EXPECT_GT(faceAreas(result.vertices, result.faces).minCoeff(), 0.01);
  EXPECT_NEAR(enclosedVolume(result.vertices, result.faces), 4.0 / 3, 1e-12);
}

TEST(SurfacePreparation, MendsAVertexOnAnEdge) {
  // One of the two faces at edge 0-1 is split there, the other is not: a crack without width.
  Mesh mesh = tetrahedron();
  Eigen::Index f = 0;
  int k = 0;
  for (Eigen::Index g = 0; g < 4; ++g)
    for (int j = 0; j < 3; ++j)
      if (mesh.faces(g, j) == 0 && mesh.faces(g, (j + 1) % 3) == 1) f = g, k = j;
  Points vertices(5, 3);
  vertices << mesh.vertices, 0.5 * (mesh.vertices.row(0) + mesh.vertices.row(1));
  mesh.vertices = vertices;
  const int apex = mesh.faces(f, (k + 2) % 3);
  mesh.faces(f, (k + 1) % 3) = 4;
  const PreparedMesh result = prepared(withFaces(mesh, {{4, 1, apex}}));
  EXPECT_TRUE(isClosed(result));
  EXPECT_EQ(result.openings.size(), 1U);
  EXPECT_GT(faceAreas(result.vertices, result.faces).minCoeff(), 0.01);
}

TEST(SurfacePreparation, RemovesAFin) {
  Mesh mesh = box(4);
  const Eigen::Index n = mesh.vertices.rows();
  Points vertices(n + 1, 3);
  vertices << mesh.vertices, Eigen::RowVector3d(1.5, 1.5, 1.5);
  mesh.vertices = vertices;
  const int f = 10;
  const PreparedMesh result =
      prepared(withFaces(mesh, {{mesh.faces(f, 0), mesh.faces(f, 1), static_cast<int>(n)},
                                {static_cast<int>(n), mesh.faces(f, 1), mesh.faces(f, 2)}}));
  EXPECT_TRUE(isClosed(result));
  EXPECT_EQ(result.faces, mesh.faces);
  EXPECT_EQ(result.sheets.edges, 2);
  EXPECT_EQ(result.sheets.droppedFaces, 2);
}

TEST(SurfacePreparation, RemovesAFlangeRoundAnOpenSurface) {
  Mesh mesh = bowl(0.4, 32, 12);
  const int row = 5, n = static_cast<int>(mesh.vertices.rows());
  Points vertices(n + 32, 3);
  vertices.topRows(n) = mesh.vertices;
  std::vector<std::array<int, 3>> flange;
  for (int i = 0; i < 32; ++i) {
    vertices.row(n + i) = 1.6 * mesh.vertices.row(32 * row + i);
    const int j = (i + 1) % 32;
    flange.push_back({32 * row + i, 32 * row + j, n + i});
    flange.push_back({n + i, 32 * row + j, n + j});
  }
  const Eigen::Index wall = mesh.faces.rows();
  mesh.vertices = vertices;
  const PreparedMesh result = prepared(withFaces(mesh, flange));
  EXPECT_TRUE(isClosed(result));
  EXPECT_EQ(result.sheets.droppedFaces, 64);
  EXPECT_EQ(result.faces.topRows(wall), mesh.faces);
  EXPECT_EQ(result.openings.size(), 1U);
}

TEST(SurfacePreparation, RemovesAnInternalMembrane) {
  Mesh mesh = bowl(0.6, 32, 16);
  const int row = 7, n = static_cast<int>(mesh.vertices.rows());
  Points vertices(n + 1, 3);
  vertices << mesh.vertices, Eigen::RowVector3d(0, 0, mesh.vertices(32 * row, 2));
  mesh.vertices = vertices;
  std::vector<std::array<int, 3>> membrane;
  for (int i = 0; i < 32; ++i) membrane.push_back({32 * row + i, 32 * row + (i + 1) % 32, n});
  const PreparedMesh result = prepared(withFaces(mesh, membrane));
  EXPECT_TRUE(isClosed(result));
  EXPECT_EQ(result.sheets.edges, 32);
  EXPECT_EQ(result.sheets.droppedFaces, 32);
  double wall = 0;
  for (Eigen::Index f = 0; f < 32 * (2 * 16 - 1); ++f)
    wall += faceAreas(result.vertices, result.faces)[f];
  const double disc = 16 * std::sin(pi / 16) * (1 - std::pow(mesh.vertices(32 * row, 2), 2));
  EXPECT_NEAR(result.sheets.droppedShare, disc / (wall + disc), 1e-9);
}

TEST(SurfacePreparation, WeldsAllThreeRimsAtAMembrane) {
  // A lower part and a membrane whose rims are the same, and an upper part that is off, somewhere.
  const int around = 32, rows = 8;
  const double z = -0.2;
  const Mesh lower = bowl(z, around, rows);
  Mesh upper = stretched(bowl(-z, around, 2 * rows), 1, 1, -1);
  Mesh membrane{Points(around + 1, 3), Triangles(around, 3)};
  membrane.vertices << lower.vertices.topRows(around), Eigen::RowVector3d(0, 0, z);
  for (int i = 0; i < around; ++i) membrane.faces.row(i) << i, (i + 1) % around, around;
  upper.vertices.topRows(around) = lower.vertices.topRows(around);
  for (const double off : {0.0, 1e-15, 1e-12, 1e-7})
    for (const bool everywhere : {false, true})
      for (const bool separately : {false, true}) {
        Mesh part = upper;
        for (int v = 0; v < around; ++v)
          if (everywhere || part.vertices(v, 0) > 0) part.vertices(v, 1) += off;
        const Mesh all = both(both(lower, part), membrane);
        const PreparedMesh result = prepared(separately ? soup(all) : all);
        EXPECT_TRUE(isClosed(result)) << off << everywhere << separately;
        EXPECT_EQ(result.faces.rows(), lower.faces.rows() + upper.faces.rows())
            << off << everywhere << separately;
        EXPECT_EQ(result.sheets.droppedFaces, around);
        EXPECT_EQ(result.dropped.parts, 0);
      }
  // The two sides of a thin wall, one of which has a hole, are no such rims.
  int seen = 0;
  const Mesh thin = without(stretched(box(4), 1, 1, 1e-9), [&seen](const Vector3& c) {
    return c.z() > 0.9e-9 && c.x() > 0.3 && ++seen == 1;
  });
  const PreparedMesh result = prepared(soup(thin));
  EXPECT_TRUE(isClosedThoughFlat(result));
  EXPECT_EQ(result.weldedVertices, 3 * thin.faces.rows() - thin.vertices.rows());
}

TEST(SurfacePreparation, CutsBodiesThatShareAnEdgeApart) {
  const Mesh box1 = box(2);
  const Mesh box2 = moved(stretched(box(2), 0.5, 0.5, 1), 1, 1, 0);
  const PreparedMesh result = prepared(soup(both(box1, box2)));  // welded, they share an edge
  EXPECT_TRUE(isClosed(result));
  EXPECT_EQ(result.sheets.edges, 2);
  EXPECT_EQ(result.sheets.droppedFaces, 0);
  EXPECT_EQ(result.dropped.parts, 1);
  EXPECT_NEAR(enclosedVolume(result.vertices, result.faces), 1, 1e-12);
  EXPECT_TRUE(isClosed(prepared(nonManifoldEdge())));
}

TEST(SurfacePreparation, SeparatesSheetsThatTouchInAVertex) {
  const PreparedMesh result = prepared(nonManifoldVertex());
  EXPECT_TRUE(isClosed(result));
  EXPECT_EQ(result.sheets.vertices, 1);
  EXPECT_EQ(result.dropped.parts, 1);
}

TEST(SurfacePreparation, OrientsFacesAlikeAndOutwards) {
  EXPECT_EQ(prepared(flippedFace()).turnedFaces, 1);
  EXPECT_EQ(prepared(inwardSphere()).turnedFaces, 20);
  Mesh mesh = icosphereMesh(5);
  for (Eigen::Index f = 0; f < mesh.faces.rows(); f += 3)
    std::swap(mesh.faces(f, 0), mesh.faces(f, 1));
  const PreparedMesh result = prepared(mesh);
  EXPECT_TRUE(isClosed(result));
  EXPECT_EQ(result.turnedFaces, (mesh.faces.rows() + 2) / 3);
}

TEST(SurfacePreparation, TellsWhatHasOneSideOnly) {
  const PreparedMesh strip = prepared(moebiusStrip());
  EXPECT_TRUE(strip.left);
  EXPECT_TRUE(strip.oneSided);
  // Beside something larger it is one of the parts that may go.
  PreparationParameters parameters;
  parameters.keepLargestComponent = false;
  const Mesh two = both(stretched(icosphereMesh(4), 9, 9, 9), moebiusStrip());
  EXPECT_FALSE(prepared(two, parameters).oneSided);
  EXPECT_TRUE(prepared(two, parameters).left);
  EXPECT_TRUE(isClosed(prepared(two)));
  EXPECT_FALSE(prepared(openCone()).oneSided);
}

TEST(SurfacePreparation, ClosesACone) {
  const PreparedMesh result = prepared(openCone());
  EXPECT_TRUE(isClosed(result));
  ASSERT_EQ(result.openings.size(), 1U);
  EXPECT_EQ(result.openings[0].edges, 8);
}

TEST(SurfacePreparation, ClosesHolesOfAllSizes) {
  for (const double z : {-0.5, 0.0, 0.5, 0.9, 0.99})
    for (const LidShape shape : {LidShape::Curved, LidShape::Flat}) {
      PreparationParameters parameters;
      parameters.lid = shape;
      const PreparedMesh result = prepared(
          without(icosphereMesh(12), [z](const Vector3& c) { return c.z() > z; }), parameters);
      EXPECT_TRUE(isClosed(result));
      EXPECT_EQ(result.openings.size(), 1U);
    }
}

TEST(SurfacePreparation, ContinuesASphere) {
  PreparationParameters parameters;
  for (const double z : {0.8, 0.4, 0.0}) {
    const Mesh open = bowl(z, 48, 24);
    const PreparedMesh curved = prepared(open);
    ASSERT_TRUE(isClosed(curved));
    ASSERT_EQ(curved.openings.size(), 1U);
    EXPECT_EQ(curved.openings[0].edges, 48);
    EXPECT_NEAR(curved.openings[0].perimeter, 96 * std::sin(pi / 48) * std::sqrt(1 - z * z), 1e-9);
    double top = 0;
    for (Eigen::Index v = 0; v < curved.vertices.rows(); ++v)
      if (curved.lid[v] > 0) {
        EXPECT_LT(curved.vertices.row(v).norm(), 1.05);
        top = std::max(top, curved.vertices(v, 2));
      }
    EXPECT_GT(top, z + 0.45 * (1 - z));
    parameters.lid = LidShape::Flat;
    const PreparedMesh flat = prepared(open, parameters);
    ASSERT_TRUE(isClosed(flat));
    for (Eigen::Index v = 0; v < flat.vertices.rows(); ++v)
      if (flat.lid[v] > 0) {
        EXPECT_NEAR(flat.vertices(v, 2), z, 1e-12);
      }
  }
}

TEST(SurfacePreparation, MakesNoLidWiderThanItsRim) {
  const double z = -0.5, radius = std::sqrt(1 - z * z);  // the wall widens towards the rim
  const PreparedMesh result = prepared(bowl(z, 48, 16));
  ASSERT_TRUE(isClosed(result));
  for (Eigen::Index v = 0; v < result.vertices.rows(); ++v)
    if (result.lid[v] > 0) {
      EXPECT_LT(result.vertices.row(v).head<2>().norm(), 1.02 * radius);
      EXPECT_GT(result.vertices(v, 2), z);
    }
}

TEST(SurfacePreparation, MarksLidsAndKeepsTheWall) {
  const Mesh open = bowl(0.3, 40, 20);
  const PreparedMesh result = prepared(open);
  const Eigen::Index n = open.vertices.rows();
  EXPECT_EQ(result.vertices.topRows(n), open.vertices);
  EXPECT_EQ(result.faces.topRows(open.faces.rows()), open.faces);
  for (Eigen::Index v = 0; v < result.vertices.rows(); ++v) {
    EXPECT_EQ(result.lid[v], v < n ? 0 : 1);
    EXPECT_EQ(result.source[v], v < n ? v : -1);
  }
  // Triangles like those around.
  const double wall = meanEdgeLength(open.vertices, open.faces);
  const double lid = meanEdgeLength(
      result.vertices, result.faces.bottomRows(result.faces.rows() - open.faces.rows()));
  EXPECT_GT(lid, 0.5 * wall);
  EXPECT_LT(lid, 1.5 * wall);
  EXPECT_GT(result.openings[0].newVertices, 100);
}

TEST(SurfacePreparation, ClosesEachOfTwoOpeningsByItself) {
  const PreparedMesh result =
      prepared(without(icosphereMesh(10), [](const Vector3& c) { return std::fabs(c.z()) > 0.6; }));
  EXPECT_TRUE(isClosed(result));
  ASSERT_EQ(result.openings.size(), 2U);
  EXPECT_EQ(std::set<int>(result.lid.begin(), result.lid.end()), (std::set<int>{0, 1, 2}));
}

TEST(SurfacePreparation, ClosesHolesThatTouch) {
  // Two holes, one vertex of a rim in common.
  const Mesh sphere = icosphereMesh(6);
  const Vector3 p = sphere.vertices.row(100).transpose();
  const Vector3 side = p.unitOrthogonal();
  const PreparedMesh result = prepared(without(sphere, [&](const Vector3& c) {
    const Vector3 d = c - p;
    return d.norm() < 0.25 && std::fabs(d.dot(side)) > std::fabs(d.dot(p.cross(side)));
  }));
  EXPECT_TRUE(isClosed(result));
  EXPECT_GE(result.openings.size(), 2U);
}

TEST(SurfacePreparation, NamesAWallWithoutItsRim) {
  const Mesh outer = bowl(0.2, 32, 12);
  Mesh inner = stretched(bowl(0.2, 32, 12), 0.8, 0.8, 0.8);
  inner.faces.col(1).swap(inner.faces.col(2));
  const PreparedMesh result = prepared(both(outer, inner));
  EXPECT_TRUE(isClosed(result));
  EXPECT_EQ(result.dropped.parts, 1);
  EXPECT_NEAR(result.dropped.largestShare, 0.64, 1e-9);
  EXPECT_TRUE(result.shells);
}

TEST(SurfacePreparation, JoinsTheSidesOfAWallWhereAsked) {
  PreparationParameters join;
  join.joinShells = true;
  const Mesh outer = bowl(0.2, 32, 12);
  for (const auto& [around, rows, size] : {std::tuple(32, 12, 0.8), {19, 9, 0.7}, {50, 20, 0.9}})
    for (const bool inwards : {true, false})
      for (const bool innerFirst : {true, false}) {
        if (underSanitizer() && around != 32 && inwards == innerFirst) continue;
        Mesh inner = moved(stretched(bowl(0.15, around, rows), size, size, size), 0.03, 0, 0);
        if (inwards) inner.faces.col(1).swap(inner.faces.col(2));
        const PreparedMesh result =
            prepared(innerFirst ? both(inner, outer) : both(outer, inner), join);
        ASSERT_TRUE(isClosed(result)) << around;
        EXPECT_EQ(result.joinedShells, 1);
        EXPECT_FALSE(result.shells);
        EXPECT_EQ(result.dropped.parts, 0);
        ASSERT_EQ(result.openings.size(), 1U);
        EXPECT_EQ(result.openings[0].edges, 32 + around);
        EXPECT_GT(result.openings[0].newFaces, 32 + around - 1);
        EXPECT_EQ(result.vertices.rows() - result.openings[0].newVertices,
                  outer.vertices.rows() + inner.vertices.rows());
        // What lies between: a sphere's part below the height z has (2 + 3 z - z^3) pi / 3.
        const auto below = [](double z, double r) {
          return r * r * r * (2 + 3 * z - z * z * z) * pi / 3;
        };
        const double wall = below(0.2, 1) - below(0.15, size);
        EXPECT_NEAR(enclosedVolume(result.vertices, result.faces), wall, 0.2 * wall + 0.05);
      }
}

/// An ellipsoid without the faces within `radius` of rays from its middle.
Mesh valved(const Mesh& ellipsoid, const std::vector<Vector3>& rays, double radius) {
  return without(ellipsoid, [&](const Vector3& c) {
    return std::any_of(rays.begin(), rays.end(), [&](const Vector3& ray) {
      const Vector3 way = ray.normalized();
      return c.dot(way) > 0 && (c - way * c.dot(way)).norm() < radius;
    });
  });
}

TEST(SurfacePreparation, JoinsWallsThatAreOpenAtSeveralValves) {
  PreparationParameters join;
  join.joinShells = true;
  const Mesh outer = stretched(icosphereMesh(sizeFor(16, 12)), 35, 35, 50),
             inner = stretched(icosphereMesh(sizeFor(14, 10)), 25, 25, 40);
  const double wall = 4 * pi / 3 * (35 * 35 * 50 - 25 * 25 * 40);
  const Vector3 mitral(-0.35, 0, 1), aortic(0.45, 0, 0.9), side(0, 1, 0.3);
  for (const LidShape lid : {LidShape::Curved, LidShape::Flat})
    for (const std::vector<Vector3>& valves :
         {std::vector<Vector3>{mitral, aortic}, {mitral, aortic, side}, {side, -side}})
      for (const auto& [radius, unit] : {std::pair(6.0, 1.0), {9.0, 0.001}}) {
        if (underSanitizer() && (lid == LidShape::Flat) != (unit == 1)) continue;
        join.lid = lid;
        Mesh in = valved(inner, valves, radius);
        in.faces.col(1).swap(in.faces.col(2));
        Mesh mesh = both(in, valved(outer, valves, radius + 1));
        mesh.vertices *= unit;
        EXPECT_TRUE(prepared(mesh).shells);
        const PreparedMesh result = prepared(mesh, join);
        ASSERT_TRUE(isClosed(result));
        EXPECT_EQ(result.joinedShells, 1);
        EXPECT_EQ(result.rings, 1);
        EXPECT_EQ(result.openings.size(), 2 * valves.size() - 1);
        EXPECT_EQ(result.dropped.parts, 0);
        EXPECT_NEAR(enclosedVolume(result.vertices, result.faces) / std::pow(unit, 3) / wall, 1,
                    0.05);
      }
}

TEST(SurfacePreparation, JoinsAnInnerSideWithTwoOpeningsInOneOfTheOuter) {
  PreparationParameters join;
  join.joinShells = true;
  const Mesh outer = without(stretched(icosphereMesh(24), 35, 35, 50),
                             [](const Vector3& c) { return c.z() > 42; });
  const Mesh inner =
      valved(stretched(icosphereMesh(24), 25, 25, 40), {{-0.27, 0, 1}, {0.3, 0, 1}}, 7);
  const PreparedMesh result = prepared(both(outer, inner), join);
  ASSERT_TRUE(isClosed(result));
  EXPECT_EQ(result.joinedShells, 1);
  ASSERT_EQ(result.openings.size(), 2U);
  EXPECT_EQ(result.openings[1].shape, LidShape::Flat);  // under the ring
  for (Eigen::Index v = 0; v < result.vertices.rows(); ++v) EXPECT_LT(result.vertices(v, 2), 44);
}

TEST(SurfacePreparation, JoinsBothVentriclesToOneOuterSide) {
  PreparationParameters join;
  join.joinShells = true;
  const auto base = [](const Mesh& mesh) {
    return without(mesh, [](const Vector3& c) { return c.z() > 25; });
  };
  const Mesh epi = stretched(icosphereMesh(20), 46, 38, 55),
             left = moved(stretched(icosphereMesh(14), 18, 20, 40), -14, 0, 0),
             right = moved(stretched(icosphereMesh(14), 14, 20, 36), 20, 0, 0);
  const Mesh cut = both(base(right), both(base(epi), base(left)));
  const PreparedMesh result = prepared(cut, join);
  ASSERT_TRUE(isClosed(result));
  EXPECT_EQ(result.joinedShells, 2);
  ASSERT_EQ(result.openings.size(), 1U);  // one ring
  const auto below = [](double z, double a, double b, double c) {
    const double t = z / c;
    return pi * a * b * c * (2.0 / 3 + t - t * t * t / 3);
  };
  const double wall = below(25, 46, 38, 55) - below(25, 18, 20, 40) - below(25, 14, 20, 36);
  EXPECT_NEAR(enclosedVolume(result.vertices, result.faces) / wall, 1, 0.03);

  // Each at a valve of its own.
  const auto hole = [](const Mesh& mesh, const Vector3& centre) {
    return without(mesh, [&](const Vector3& c) { return (c - centre).norm() < 10; });
  };
  const PreparedMesh two = prepared(both(valved(epi, {{-0.3, 0, 1}, {0.4, 0, 1}}, 9),
                                         both(hole(left, {-14, 0, 40}), hole(right, {20, 0, 36}))),
                                    join);
  ASSERT_TRUE(isClosed(two));
  EXPECT_EQ(two.joinedShells, 2);
  EXPECT_EQ(two.rings, 2);
}

TEST(SurfacePreparation, JoinsAndClosesRimsThatTouchThemselves) {
  const auto ragged = [](const Mesh& mesh) {
    return without(mesh, [](const Vector3& c) {
      return c.z() > 0.4 + 0.2 * std::sin(4321 * c.x() + 1234 * c.y());
    });
  };
  const Mesh outer = ragged(icosphereMesh(20)),
             inner = ragged(stretched(icosphereMesh(20), 0.75, 0.75, 0.9));
  PreparationParameters join;
  join.joinShells = true;
  const PreparedMesh result = prepared(both(outer, inner), join);
  ASSERT_TRUE(isClosed(result));
  EXPECT_EQ(result.joinedShells, 1);
  join.joinShells = false;
  join.removeFins = false;
  EXPECT_TRUE(isClosed(prepared(outer, join)));
}

TEST(SurfacePreparation, JoinsNothingElse) {
  PreparationParameters join;
  join.joinShells = true;
  const Mesh bowlMesh = bowl(0.2, 32, 12), small = stretched(bowl(0.2, 32, 12), 0.6, 0.6, 0.6);
  const Eigen::Matrix3d half = Eigen::AngleAxisd(pi / 2, Vector3::UnitX()).toRotationMatrix();
  for (const Mesh& other : {moved(small, 3, 0, 0),                          // beside
                            transformed(small, half, 1, Vector3::Zero()),   // open to the side
                            stretched(bowl(0.2, 32, 12), 0.2, 0.2, 0.2),    // much smaller
                            stretched(icosphereMesh(6), 0.5, 0.5, 0.5)}) {  // closed
    const PreparedMesh result = prepared(both(bowlMesh, other), join);
    EXPECT_TRUE(isClosed(result));
    EXPECT_EQ(result.joinedShells, 0);
    EXPECT_FALSE(prepared(both(bowlMesh, other)).shells);
    EXPECT_EQ(result.dropped.parts, 1);
  }
}

TEST(SurfacePreparation, MakesLidsAsFineAsTheSurfaceNotAsItsRim) {
  // Three lobes, so that the rim has inward corners, cut through their faces: slivers at the rim.
  Mesh lobes = icosphereMesh(16);
  for (Eigen::Index v = 0; v < lobes.vertices.rows(); ++v) {
    const double angle = std::atan2(lobes.vertices(v, 1), lobes.vertices(v, 0));
    lobes.vertices.row(v).head<2>() *= 1 + 0.45 * std::cos(3 * angle);
  }
  for (const double height : {-0.2, 0.013, 0.11, 0.3}) {
    const Mesh open = cutBelow(lobes, height);
    const PreparedMesh result = prepared(open);
    ASSERT_TRUE(isClosed(result)) << height;
    ASSERT_EQ(result.openings.size(), 1U);
    const Eigen::Index wall = open.faces.rows(), n = open.vertices.rows();
    EXPECT_EQ(result.vertices.topRows(n), open.vertices);
    const Eigen::VectorXd areas = faceAreas(result.vertices, result.faces);
    const double lidArea = areas.tail(areas.size() - wall).sum(), wallArea = areas.head(wall).sum();
    const double density =
        static_cast<double>(result.openings[0].newVertices) / lidArea /
        (static_cast<double>(lobes.vertices.rows()) / faceAreas(lobes.vertices, lobes.faces).sum());
    EXPECT_GT(density, 0.3) << height;
    EXPECT_LT(density, 1.5) << height;
    EXPECT_LT(wallArea, 30);
    double top = height;
    for (Eigen::Index v = n; v < result.vertices.rows(); ++v)
      top = std::max(top, result.vertices(v, 2));
    EXPECT_LT(top - height, 0.6) << height;  // the lobes' width
    EXPECT_GT(top, height);
  }
}

TEST(SurfacePreparation, TurnsWithTheMesh) {
  const Mesh open = without(noisyEllipsoid(3), [](const Vector3& c) { return c.x() > 8; });
  const PreparedMesh here = prepared(open);
  ASSERT_TRUE(isClosed(here));
  const Eigen::Matrix3d rotation = randomRotation(4);
  for (const double scale : {1.0, 1e-3, 1e4}) {
    const PreparedMesh there =
        prepared(transformed(open, rotation, scale, Vector3(3, 4, 5) * scale));
    ASSERT_EQ(there.faces, here.faces);
    const Mesh meant =
        transformed({here.vertices, here.faces}, rotation, scale, Vector3(3, 4, 5) * scale);
    EXPECT_LT(largestDistance(there.vertices, meant.vertices), 1e-6 * scale);
  }
  EXPECT_EQ(prepared(open).vertices, here.vertices);
}

TEST(SurfacePreparation, RemovesHandlesWhereAsked) {
  PreparationParameters parameters;
  EXPECT_EQ(prepared(torus()).left->fault, Fault::Handles);
  parameters.removeHandles = true;
  const PreparedMesh result = prepared(torus(), parameters);
  EXPECT_TRUE(isClosed(result));
  EXPECT_EQ(result.handles, 1);
  EXPECT_NEAR(enclosedVolume(result.vertices, result.faces) /
                  enclosedVolume(torus().vertices, torus().faces),
              1, 0.2);
}

TEST(SurfacePreparation, StepsThatAreOffDoNothing) {
  PreparationParameters none;
  none.weld = none.removeDuplicateFaces = none.removeFins = none.keepLargestComponent =
      none.closeOpenings = none.orient = false;
  for (const Mesh& mesh : {openCone(), nonManifoldEdge(), nonManifoldVertex(), twoSpheres(),
                           flippedFace(), inwardSphere(), withUnreferencedVertex()}) {
    const PreparedMesh result = prepared(mesh, none);
    EXPECT_FALSE(result.changed);
    EXPECT_TRUE(result.left);
  }
  PreparationParameters parameters;
  parameters.orient = false;
  const PreparedMesh result =
      prepared(without(flippedFace(), [](const Vector3& c) { return c.z() > 0.7; }), parameters);
  ASSERT_TRUE(result.left);
  EXPECT_EQ(result.left->fault, Fault::InconsistentOrientation);
  EXPECT_EQ(result.left->count, 3);
}

TEST(SurfacePreparation, RefusesWhatHoldsNoSurface) {
  EXPECT_THROW(prepared({octahedron().vertices, Triangles(0, 3)}), SurfaceError);
  EXPECT_THROW(prepared({Points(0, 3), Triangles(0, 3)}), SurfaceError);
  EXPECT_THROW(prepared(withFaces(octahedron(), {{0, 1, 6}})), SurfaceError);
  const Mesh one{octahedron().vertices.topRows(3), Triangles{{0, 1, 2}}};
  EXPECT_TRUE(prepared(one).left);
}

/// Anything: faces gone, there twice, turned, fins between any vertices, loose parts, split
/// vertices.
Mesh damaged(unsigned seed) {
  Random random(seed);
  Mesh mesh = noisyEllipsoid(seed);
  const double lost = random.uniform(0, 0.2);
  mesh = without(mesh, [&](const Vector3&) { return random.uniform() < lost; });
  std::vector<std::array<int, 3>> more;
  const int count = static_cast<int>(mesh.vertices.rows());
  for (int i = random.index(60); i > 0; --i) {
    const Eigen::Index f = random.index(static_cast<int>(mesh.faces.rows()));
    const int a = mesh.faces(f, 0), b = mesh.faces(f, 1), c = mesh.faces(f, 2);
    switch (random.index(4)) {
      case 0:
        more.push_back({b, a, c});
        break;
      case 1:
        more.push_back({a, b, random.index(count)});
        break;
      case 2:
        more.push_back({random.index(count), random.index(count), random.index(count)});
        break;
      default:
        std::swap(mesh.faces(f, 1), mesh.faces(f, 2));
    }
  }
  mesh = withFaces(mesh, more);
  if (seed % 3 == 0) mesh = soup(mesh);
  return mesh;
}

TEST(SurfacePreparation, MakesAClosedSurfaceOfAnything) {
  PreparationParameters parameters;
  parameters.removeHandles = true;
  int bad = 0;
  for (int s = 0; s < sizeFor(100, 25); ++s) {
    const auto seed = static_cast<unsigned>(s);
    parameters.lid = seed % 2 == 0 ? LidShape::Curved : LidShape::Flat;
    const Mesh mesh = damaged(seed);
    const PreparedMesh result = prepared(mesh, parameters);
    EXPECT_TRUE(isClosed(result)) << "seed " << seed;
    bad += result.left.has_value();
    if (!result.left) {
      EXPECT_FALSE(prepared({result.vertices, result.faces}).changed) << "seed " << seed;
    }
  }
  EXPECT_EQ(bad, 0);
}

}  // namespace
}  // namespace sphere_propagation::test
