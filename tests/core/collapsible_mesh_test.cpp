// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/hierarchy/collapsible_mesh.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <vector>

#include "tests/core/limb_meshes.h"
#include "vcg_ext/mesh/hierarchy/simplification.h"
#include "vcg_ext/mesh/hierarchy/spatial_order.h"

namespace sphere_propagation::test {
namespace {

CollapsibleMesh collapsible(const Mesh& mesh) {
  std::vector<int> order(static_cast<size_t>(mesh.vertices.rows()));
  std::iota(order.begin(), order.end(), 0);
  return {ClosedSurface(mesh.vertices, mesh.faces), order};
}

/// The faces with their areas, each from its least vertex, sorted: the same for the same mesh.
std::vector<std::array<double, 4>> facesOf(const CollapsibleMesh& mesh) {
  std::vector<int> vertices, faceOf;
  const FaceRings rings = mesh.rings(vertices, faceOf);
  std::vector<std::array<double, 4>> faces;
  for (int f = 0; f < rings.faceCount(); ++f) {
    Eigen::RowVector3i face = rings.faces.row(f);
    while (face.minCoeff() != face[0]) face = Eigen::RowVector3i(face[1], face[2], face[0]);
    faces.push_back({static_cast<double>(vertices[face[0]]), static_cast<double>(vertices[face[1]]),
                     static_cast<double>(vertices[face[2]]),
                     static_cast<double>(mesh.area(3 * faceOf[f]))});
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

/// Throws where it is not a closed surface of genus 0 any more.
void expectSphere(const CollapsibleMesh& mesh) {
  std::vector<int> vertices, faceOf;
  const FaceRings rings = mesh.rings(vertices, faceOf);
  Points points(static_cast<Eigen::Index>(vertices.size()), 3);
  Random random(1);
  for (Eigen::Index v = 0; v < points.rows(); ++v) points.row(v) = random.direction().transpose();
  ASSERT_EQ(rings.vertexCount(), mesh.vertexCount());
  const Vector3 inside = points.colwise().mean();
  try {
    ClosedSurface(points, rings.faces);
  } catch (const SurfaceError& error) {  // these points say nothing about inside and outside
    EXPECT_EQ(error.fault(), Fault::InwardOrientation) << error.what() << inside;
  }
}

std::vector<Mesh> meshes() {
  return {tetrahedron(),        octahedron(),  noisyEllipsoid(1), box(3),
          bipyramid(200),       tetrapod(5),   rings(1e-6),       cup(0.1, 12, 5),
          withZeroAreaFace(),   tree(1, 2, 1), disc(6),           coil(1, 6, 20),
          ellipsoid(30, 20, 0), bipyramid(3)};
}

TEST(CollapsibleMesh, CollapsesToATetrahedronAndComesBackExactly) {
  for (const Mesh& mesh : meshes()) {
    CollapsibleMesh collapsing = collapsible(mesh);
    const auto before = facesOf(collapsing);
    ThreadPool pool;
    const std::vector<int> rounds = simplify(collapsing, pool);
    EXPECT_EQ(collapsing.vertexCount(), 4);
    EXPECT_EQ(std::accumulate(rounds.begin(), rounds.end(), 0), mesh.vertices.rows() - 4);
    expectSphere(collapsing);
    for (Eigen::Index i = 4; i < mesh.vertices.rows(); ++i) {
      const int h = collapsing.lastCollapse(), u = collapsing.origin(h), v = collapsing.target(h);
      EXPECT_FALSE(collapsing.isThere(u));
      EXPECT_TRUE(collapsing.isThere(v));
      EXPECT_EQ(collapsing.undo(), u);
      EXPECT_EQ(collapsing.target(collapsing.someHalfEdge(u)), v);
    }
    EXPECT_EQ(facesOf(collapsing), before);
  }
}

TEST(CollapsibleMesh, IsASphereAtEveryStage) {
  for (const Mesh& mesh : {noisyEllipsoid(2), bipyramid(40), tetrapod(5)}) {
    CollapsibleMesh collapsing = collapsible(mesh);
    ThreadPool pool;
    simplify(collapsing, pool);
    double total = 0;
    for (const auto& face : facesOf(collapsing)) total += face[3];
    while (collapsing.vertexCount() < mesh.vertices.rows()) {
      collapsing.undo();
      if (collapsing.vertexCount() % 7 == 0) {
        expectSphere(collapsing);
        double sum = 0;
        for (const auto& face : facesOf(collapsing)) sum += face[3];
        EXPECT_NEAR(sum / total, 1, 1e-4);
      }
    }
  }
}

TEST(CollapsibleMesh, EveryVertexCanGoSomewhere) {
  for (const Mesh& mesh : meshes()) {
    if (mesh.vertices.rows() == 4) continue;
    const CollapsibleMesh collapsing = collapsible(mesh);
    for (int v = 0; v < collapsing.allVertices(); ++v) {
      int h = collapsing.someHalfEdge(v), possible = 0;
      for (int i = 0; i < collapsing.degree(v); ++i, h = collapsing.turned(h))
        possible += collapsing.canCollapse(h);
      EXPECT_GE(possible, 1) << "vertex " << v << " of " << mesh.vertices.rows();
    }
  }
}

TEST(CollapsibleMesh, RefusesWhatWouldTearTheSphere) {
  // Between the apexes of a bipyramid with three sides there is no edge, but the equator is a ring
  // of three: to take a vertex of it away along the equator would fold two faces onto each other.
  const CollapsibleMesh mesh = collapsible(bipyramid(3));
  for (int v : {2, 3, 4}) {
    int h = mesh.someHalfEdge(v);
    for (int i = 0; i < mesh.degree(v); ++i, h = mesh.turned(h))
      EXPECT_EQ(mesh.canCollapse(h), mesh.target(h) < 2) << v << " to " << mesh.target(h);
  }
  const CollapsibleMesh smallest = collapsible(tetrahedron());
  for (int h = 0; h < 12; ++h) EXPECT_FALSE(smallest.canCollapse(h));
}

TEST(CollapsibleMesh, RingsAreThoseOfTheSurface) {
  const Mesh mesh = noisyEllipsoid(3);
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  std::vector<int> order = spatialOrder(mesh.vertices), sorted = order, vertices, faceOf;
  std::sort(sorted.begin(), sorted.end());
  for (int i = 0; i < surface.vertexCount(); ++i) ASSERT_EQ(sorted[i], i);
  const FaceRings rings = CollapsibleMesh(surface, order).rings(vertices, faceOf);
  for (int i = 0; i < surface.vertexCount(); ++i) {
    const IndexRange expected = surface.ring(order[i]);
    ASSERT_EQ(rings.offset[i + 1] - rings.offset[i], expected.size());
    std::vector<int> found;
    for (int j = rings.offset[i]; j < rings.offset[i + 1]; ++j) {
      const int c = rings.corner[j];
      EXPECT_EQ(rings.faces.data()[c], i);
      found.push_back(order[rings.second(c)]);
    }
    const auto start = std::find(found.begin(), found.end(), expected[0]);
    ASSERT_NE(start, found.end());
    std::rotate(found.begin(), start, found.end());
    EXPECT_TRUE(std::equal(found.begin(), found.end(), expected.begin()));
  }
}

TEST(Simplification, TakesNoTwoNeighboursInOneRound) {
  const Mesh mesh = noisyEllipsoid(4);
  CollapsibleMesh collapsing = collapsible(mesh);
  ThreadPool pool;
  const std::vector<int> rounds = simplify(collapsing, pool);
  EXPECT_LT(rounds.size(), 60U);
  for (auto round = rounds.rbegin(); round != rounds.rend(); ++round) {
    std::vector<int> back;
    for (int i = 0; i < *round; ++i) back.push_back(collapsing.undo());
    std::sort(back.begin(), back.end());
    for (int v : back) {
      int h = collapsing.someHalfEdge(v);
      for (int i = 0; i < collapsing.degree(v); ++i, h = collapsing.turned(h))
        EXPECT_FALSE(std::binary_search(back.begin(), back.end(), collapsing.target(h)));
    }
  }
}

TEST(Simplification, KeepsTheEndsOfLimbs) {
  const Mesh mesh = limbs(20, 2);
  CollapsibleMesh collapsing = collapsible(mesh);
  ThreadPool pool;
  simplify(collapsing, pool);
  while (collapsing.vertexCount() < 40) collapsing.undo();
  // Of 3874 vertices forty are left, and still some at each end.
  const double reach = mesh.vertices.rowwise().norm().maxCoeff();
  for (int f = 0; f < 4; ++f) {
    const Eigen::RowVector3i base = tetrahedron().faces.row(f);
    Vector3 outward = Vector3::Zero();
    for (int k = 0; k < 3; ++k) outward += tetrahedron().vertices.row(base[k]).transpose() / 3;
    outward.normalize();
    double farthest = 0;
    for (int v = 0; v < collapsing.allVertices(); ++v)
      if (collapsing.isThere(v)) farthest = std::max(farthest, mesh.vertices.row(v).dot(outward));
    EXPECT_GT(farthest, 0.8 * reach) << "limb " << f;
  }
}

}  // namespace
}  // namespace sphere_propagation::test
