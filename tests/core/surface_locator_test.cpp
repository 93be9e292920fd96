// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/surface_locator.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "tests/core/test_meshes.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation::test {
namespace {

Vector3 corner(const Mesh& mesh, Eigen::Index f, int k) {
  return mesh.vertices.row(mesh.faces(f, k)).transpose();
}

/// Distance from x to a triangle by its definition, without regions: inside the prism over it the
/// distance to the plane, else to the nearest side.
double distanceToTriangle(const Vector3& x, const Vector3& a, const Vector3& b, const Vector3& c) {
  const auto toSegment = [&](const Vector3& p, const Vector3& q) {
    const double length = (q - p).squaredNorm();
    const double t = length > 0 ? std::min(1.0, std::max(0.0, (x - p).dot(q - p) / length)) : 0;
    return (x - p - t * (q - p)).norm();
  };
  const Vector3 n = (b - a).cross(c - a);
  const auto leftOf = [&](const Vector3& p, const Vector3& q) {
    return n.dot((q - p).cross(x - p)) >= 0;
  };
  if (n.norm() > 0 && leftOf(a, b) && leftOf(b, c) && leftOf(c, a))
    return std::fabs(n.normalized().dot(x - a));
  return std::min({toSegment(a, b), toSegment(b, c), toSegment(c, a)});
}

double distanceToMesh(const Vector3& x, const Mesh& mesh) {
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    least = std::min(
        least, distanceToTriangle(x, corner(mesh, f, 0), corner(mesh, f, 1), corner(mesh, f, 2)));
  return least;
}

void expectProper(const SurfacePoint& found, const Mesh& mesh, const Vector3& x, double tolerance) {
  ASSERT_GE(found.face, 0);
  ASSERT_LT(found.face, mesh.faces.rows());
  EXPECT_GE(found.weights.minCoeff(), 0);
  EXPECT_NEAR(found.weights.sum(), 1, 1e-14);
  EXPECT_NEAR((found.interpolate(mesh.faces, mesh.vertices) - x).norm(), found.distance, tolerance);
}

TEST(SurfaceLocator, AgreesWithBruteForce) {
  for (const Mesh& mesh :
       {tetrahedron(), octahedron(), noisyEllipsoid(3), torus(), withZeroAreaFace(), openCone()}) {
    const SurfaceLocator locator(mesh.vertices, mesh.faces);
    const double size = mesh.vertices.cwiseAbs().maxCoeff();
    Random random(7);
    for (int i = 0; i < 500; ++i) {
      const Vector3 x = random.direction() * size * random.uniform(0, 2);
      const SurfacePoint found = locator.closest(x);
      expectProper(found, mesh, x, 1e-14 * size);
      EXPECT_NEAR(found.distance, distanceToMesh(x, mesh), 1e-13 * size);
    }
  }
}

TEST(SurfaceLocator, TheOrderOfTheFacesChangesNothing) {
  for (const Mesh& mesh : {octahedron(), noisyEllipsoid(3), withZeroAreaFace()}) {
    const SurfaceLocator sorted(mesh.vertices, mesh.faces);
    std::vector<int> order = sorted.order(), all(static_cast<size_t>(mesh.faces.rows()));
    std::iota(all.begin(), all.end(), 0);
    EXPECT_TRUE(std::is_permutation(order.begin(), order.end(), all.begin(), all.end()));
    std::reverse(all.begin(), all.end());
    for (const std::vector<int>& given : {order, all}) {
      const SurfaceLocator locator(mesh.vertices, mesh.faces, given);
      Random random(5);
      for (int i = 0; i < 200; ++i) {
        const Vector3 x = random.direction() * random.uniform(0, 2);
        const SurfacePoint found = locator.closest(x, i % static_cast<int>(mesh.faces.rows())),
                           expected = sorted.closest(x);
        EXPECT_EQ(found.face, expected.face);
        EXPECT_EQ(found.weights, expected.weights);
        EXPECT_EQ(found.distance, expected.distance);
      }
    }
  }
}

TEST(SurfaceLocator, PointsOfTheMeshAreAtDistanceZero) {
  const Mesh mesh = noisyEllipsoid(4);
  const SurfaceLocator locator(mesh.vertices, mesh.faces);
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    const SurfacePoint found = locator.closest(mesh.vertices.row(v).transpose());
    EXPECT_EQ(found.distance, 0);
    EXPECT_EQ(found.weights.maxCoeff(), 1);
  }
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    const Vector3 centroid = (corner(mesh, f, 0) + corner(mesh, f, 1) + corner(mesh, f, 2)) / 3;
    const SurfacePoint found = locator.closest(centroid);
    EXPECT_EQ(found.face, f);
    EXPECT_LT((found.weights - Vector3::Constant(1.0 / 3)).norm(), 1e-12);
  }
}

TEST(SurfaceLocator, SmallestIndexOfEquallyCloseFaces) {
  const Mesh mesh = octahedron();
  const SurfaceLocator locator(mesh.vertices, mesh.faces);
  for (int v = 0; v < 6; ++v) {
    int first = 0;
    while ((mesh.faces.row(first).array() != v).all()) ++first;
    EXPECT_EQ(locator.closest(2 * mesh.vertices.row(v).transpose()).face, first) << "vertex " << v;
  }
  // The same face many times over: the tree cannot separate them.
  Triangles copies(100, 3);
  copies.rowwise() = Eigen::RowVector3i(0, 2, 4);
  EXPECT_EQ(SurfaceLocator(mesh.vertices, copies).closest({1, 1, 1}).face, 0);
}

TEST(SurfaceLocator, TrianglesWithoutArea) {
  Points vertices(7, 3);
  vertices << 0, 0, 0, 1, 0, 0, 3, 0, 0, 5, 5, 5, 5, 5, 5, 5, 5, 5, 1, 1e-13, 0;
  Triangles faces(1, 3);
  for (const Eigen::RowVector3i& segment :
       {Eigen::RowVector3i(0, 1, 2), Eigen::RowVector3i(1, 2, 0), Eigen::RowVector3i(2, 0, 1),
        Eigen::RowVector3i(0, 2, 1), Eigen::RowVector3i(0, 0, 2), Eigen::RowVector3i(0, 6, 2)}) {
    faces << segment;
    const SurfaceLocator locator(vertices, faces);
    const SurfacePoint middle = locator.closest({2, 3, 4}), end = locator.closest({6, 4, 0});
    EXPECT_NEAR(middle.distance, 5, 1e-12);
    EXPECT_LT((middle.interpolate(faces, vertices) - Vector3(2, 0, 0)).norm(), 1e-12);
    EXPECT_NEAR(end.distance, 5, 1e-12);
    EXPECT_EQ(locator.closest({2, 3, 4}, {0, 0, 1}, -1).face,
              -1);  // agrees with no direction, not even any
  }
  faces << 3, 4, 5;
  const SurfacePoint point = SurfaceLocator(vertices, faces).closest({5, 5, 8});
  EXPECT_EQ(point.distance, 3);
  EXPECT_EQ(point.weights.sum(), 1);
}

TEST(SurfaceLocator, ThinTriangleKeepsItsDigits) {
  // Height over length 1e-7: Ericson's own formula would lose all digits of the weights here.
  Points vertices(3, 3);
  vertices << 0, 0, 0, 1, 0, 0, 0.5, 1e-7, 0;
  Triangles faces(1, 3);
  faces << 0, 1, 2;
  const SurfaceLocator locator(vertices, faces);
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    Vector3 w(random.uniform(), random.uniform(), random.uniform());
    w /= w.sum();
    const Vector3 foot = vertices.transpose() * w;
    const SurfacePoint found = locator.closest(foot + Vector3(0, 0, 0.25));
    EXPECT_NEAR(found.distance, 0.25, 1e-15);
    EXPECT_LT((found.interpolate(faces, vertices) - foot).norm(), 1e-9);
  }
}

TEST(SurfaceLocator, OnlyFacesThatAgreeWithTheDirection) {
  const Mesh mesh = noisyEllipsoid(5);
  const Points normals = faceNormals(mesh.vertices, mesh.faces);
  const SurfaceLocator locator(mesh.vertices, mesh.faces);
  Random random(11);
  for (int i = 0; i < 300; ++i) {
    const Vector3 x = random.direction() * random.uniform(0, 40), direction = random.direction();
    const double minCosine = random.uniform(-1, 1);
    double least = std::numeric_limits<double>::infinity();
    for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
      if (normals.row(f).dot(direction) >= minCosine)
        least = std::min(least, distanceToTriangle(x, corner(mesh, f, 0), corner(mesh, f, 1),
                                                   corner(mesh, f, 2)));
    const SurfacePoint found = locator.closest(x, direction, minCosine);
    if (std::isinf(least)) {
      EXPECT_EQ(found.face, -1);
      continue;
    }
    expectProper(found, mesh, x, 1e-12);
    EXPECT_GE(normals.row(found.face).dot(direction), minCosine - 1e-15);
    EXPECT_NEAR(found.distance, least, 1e-12);
  }
  EXPECT_EQ(locator.closest({0, 0, 0}, {0, 0, 1}, 1.5).face, -1);
}

TEST(SurfaceLocator, WhereItLooksFirstChangesNothing) {
  const Mesh mesh = noisyEllipsoid(5);
  const SurfaceLocator locator(mesh.vertices, mesh.faces);
  Random random(14);
  for (int i = 0; i < 300; ++i) {
    const Vector3 x = 40 * random.direction() * random.uniform(), direction = random.direction();
    const int near = random.index(static_cast<int>(mesh.faces.rows()));
    EXPECT_EQ(locator.closest(x, near).face, locator.closest(x).face);
    EXPECT_EQ(locator.closest(x, near).weights, locator.closest(x).weights);
    EXPECT_EQ(locator.closest(x, direction, 0.5, near).face,
              locator.closest(x, direction, 0.5).face);
  }
}

TEST(SurfaceLocator, TinyAndHugeCoordinates) {
  for (const double scale : {1e-30, 1e30}) {
    const Mesh small = ellipsoid(3, 2, 1, 4);
    const Mesh mesh = transformed(small, Eigen::Matrix3d::Identity(), scale, Vector3::Zero());
    const SurfaceLocator locator(mesh.vertices, mesh.faces), unscaled(small.vertices, small.faces);
    Random random(13);
    for (int i = 0; i < 100; ++i) {
      const Vector3 x = random.direction() * random.uniform(0, 5);
      EXPECT_NEAR(locator.closest(scale * x).distance / scale, unscaled.closest(x).distance, 1e-13);
    }
  }
}

}  // namespace
}  // namespace sphere_propagation::test
