// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/morphing/sphere_overlay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/core/test_meshes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/morphing/side_of_arc.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation {
namespace {

/// An ellipsoid on an icosphere that is turned, with its map.
MappedSurface turnedEllipsoid(int frequency, double a, double b, double c, unsigned seed) {
  const test::Mesh ball = test::transformed(test::icosphereMesh(frequency),
                                            test::randomRotation(seed), 1, Vector3::Zero());
  const test::Mesh mesh = test::stretched(ball, a, b, c);
  Points positions = ball.vertices;
  positions.rowwise().normalize();
  return MappedSurface(surfaceOf(mesh, "ellipsoid"), positions);
}

/// Crossings counted one pair of edges after the other.
int crossingsOf(const MappedSurface& first, const MappedSurface& second) {
  const auto edges = [](const ClosedSurface& surface) {
    std::vector<int> all;
    for (int h = 0; h < 3 * surface.faceCount(); ++h)
      if (h < surface.twin(h)) all.push_back(h);
    return all;
  };
  const ClosedSurface &a = first.surface(), &b = second.surface();
  int count = 0;
  for (const int e : edges(a))
    for (const int f : edges(b)) {
      const Vector3 p = first.position(a.origin(e)), q = first.position(a.target(e)),
                    r = second.position(b.origin(f)), s = second.position(b.target(f));
      const bool cross =
          sideOfArc(p, q, r) != sideOfArc(p, q, s) && sideOfArc(r, s, p) != sideOfArc(r, s, q);
      count += cross && (p + q).dot(r + s) > 0;  // not on the other side of the sphere
    }
  return count;
}

double farthestFrom(const Points& points, const ClosedSurface& surface) {
  const SurfaceLocator locator(surface.vertices(), surface.faces());
  double most = 0;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    most = std::max(most, locator.closest(points.row(i).transpose()).distance);
  return most;
}

TEST(SideOfArc, DecidesWhatRoundingCannot) {
  const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY();
  EXPECT_EQ(sideOfArc(x, y, Vector3(0.3, 0.7, 1e-300)), 1);
  EXPECT_EQ(sideOfArc(x, y, Vector3(0.3, 0.7, -1e-300)), -1);
  EXPECT_EQ(sideOfArc(x, y, Vector3(0.3, 0.7, 0)), 0);
  const Vector3 p(0.1, 0.2, 0.3), q(0.3, 0.1, 0.7);
  Vector3 r = p + q;  // rounded, so on one side
  EXPECT_EQ(sideOfArc(p, q, r), -sideOfArc(q, p, r));
  EXPECT_EQ(sideOfArc(p, q, 2 * p), 0);
}

TEST(SphereOverlay, HasAllVerticesAndOneForEveryCrossing) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const MappedSurface first = turnedEllipsoid(3, 3, 2, 1, seed),
                        second = turnedEllipsoid(2 + static_cast<int>(seed), 1, 2, 2, seed + 10);
    const SphereOverlay overlay = *overlayOnSphere(first, second);
    EXPECT_EQ(overlay.crossings, crossingsOf(first, second));
    EXPECT_EQ(overlay.first.vertexCount(),
              first.vertexCount() + second.vertexCount() + overlay.crossings);
    EXPECT_EQ(overlay.turn, 0);
    EXPECT_TRUE(certify(overlay.first.faces(), overlay.first.positions()).valid());
    EXPECT_TRUE(overlay.first.surface().hasFacesOf(overlay.second));
  }
}

TEST(SphereOverlay, IsBothSurfacesExactly) {
  const MappedSurface first = turnedEllipsoid(6, 3, 2, 1, 4),
                      second = turnedEllipsoid(5, 1, 2, 2, 5);
  const SphereOverlay overlay = *overlayOnSphere(first, second);
  const int n = first.vertexCount(), m = second.vertexCount();
  EXPECT_EQ(overlay.first.surface().vertices().topRows(n), first.surface().vertices());
  EXPECT_EQ(overlay.second.vertices().middleRows(n, m), second.surface().vertices());
  EXPECT_LT(farthestFrom(overlay.first.surface().vertices(), first.surface()), 1e-12);
  EXPECT_LT(farthestFrom(overlay.second.vertices(), second.surface()), 1e-12);
  const Triangles& faces = overlay.first.faces();
  const auto area = [](const ClosedSurface& s) { return faceAreas(s.vertices(), s.faces()).sum(); };
  EXPECT_NEAR(area(overlay.first.surface()), area(first.surface()), 1e-9);
  EXPECT_NEAR(area(overlay.second), area(second.surface()), 1e-9);
  EXPECT_NEAR(enclosedVolume(overlay.first.surface().vertices(), faces),
              enclosedVolume(first.surface().vertices(), first.faces()), 1e-9);
  EXPECT_NEAR(enclosedVolume(overlay.second.vertices(), faces),
              enclosedVolume(second.surface().vertices(), second.faces()), 1e-9);
}

TEST(SphereOverlay, TakesMapsWhoseVerticesAndEdgesCoincide) {
  const test::Mesh coarse = test::octahedron(), fine = test::icosphereMesh(4);
  const MappedSurface octahedron(surfaceOf(coarse), coarse.vertices);
  const MappedSurface ball(surfaceOf(fine), fine.vertices);
  const test::Mesh nested = test::icosphereMesh(2);
  const MappedSurface half(surfaceOf(nested), nested.vertices);
  for (const auto& [first, second] :
       {std::pair{octahedron, octahedron.of(surfaceOf(test::stretched(coarse, 1, 2, 3)))},
        std::pair{octahedron, ball}, std::pair{ball, half}, std::pair{half, octahedron}}) {
    const SphereOverlay overlay = *overlayOnSphere(first, second);
    EXPECT_TRUE(certify(overlay.first.faces(), overlay.first.positions()).valid());
    EXPECT_LE(overlay.turn, 1e-4);
    EXPECT_NEAR(enclosedVolume(overlay.second.vertices(), overlay.second.faces()),
                enclosedVolume(second.surface().vertices(), second.faces()), 1e-9);
  }
  const SphereOverlay one = *overlayOnSphere(ball, ball);
  EXPECT_EQ(one.first.faces(), ball.faces());
  EXPECT_EQ(one.crossings, 0);
}

TEST(SphereOverlay, TakesMapsThatDifferByRoundingAlone) {
  const test::Mesh mesh = test::icosphereMesh(6);
  const MappedSurface map(surfaceOf(mesh), mesh.vertices);
  Points positions = mesh.vertices;
  test::Random random(3);
  for (auto row : positions.rowwise())
    row = (row.transpose() + 1e-8 * random.direction()).normalized().transpose();
  const SphereOverlay overlay = *overlayOnSphere(map, MappedSurface(map.surface(), positions));
  EXPECT_TRUE(certify(overlay.first.faces(), overlay.first.positions()).valid());
  EXPECT_NEAR(enclosedVolume(overlay.second.vertices(), overlay.second.faces()),
              enclosedVolume(mesh.vertices, mesh.faces), 1e-9);
}

TEST(SphereOverlay, TakesFacesOfVeryDifferentSizes) {
  const test::Mesh rings = test::rings(1e-5);
  const MappedSurface first(surfaceOf(rings), rings.vertices);
  const test::Mesh turned = test::transformed(rings, test::randomRotation(8), 1, Vector3::Zero());
  Points positions = turned.vertices;
  positions.rowwise().normalize();
  const MappedSurface second(surfaceOf(turned), positions);
  for (const auto& [a, b] :
       {std::pair{first, second}, std::pair{first, turnedEllipsoid(12, 1, 1, 1, 9)}}) {
    const SphereOverlay overlay = *overlayOnSphere(a, b);
    EXPECT_EQ(overlay.first.vertexCount(), a.vertexCount() + b.vertexCount() + overlay.crossings);
    EXPECT_TRUE(certify(overlay.first.faces(), overlay.first.positions()).valid());
  }
}

}  // namespace
}  // namespace sphere_propagation
