// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/certificate.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "tests/core/test_meshes.h"
#include "vcg_ext/mesh/closed_surface.h"

namespace sphere_propagation::test {
namespace {

TEST(Certificate, AcceptsSpheres) {
  for (const Mesh& mesh :
       {tetrahedron(), octahedron(), icosahedron(), icosphereMesh(10), bipyramid(3), rings(1e-6)})
    for (unsigned seed = 0; seed < 5; ++seed) {
      const Mesh turned = transformed(mesh, randomRotation(seed), 1, Vector3::Zero());
      const Certificate certificate = certify(turned.faces, turned.vertices);
      EXPECT_TRUE(certificate.valid()) << certificate.reason();
      EXPECT_EQ(certificate.flippedFaces, 0);
      EXPECT_EQ(certificate.firstFlippedFace, -1);
      EXPECT_EQ(certificate.firstNotOnSphere, -1);
      EXPECT_NEAR(certificate.degree, 1, 1e-12);
      EXPECT_EQ(certificate.reason(), "");
    }
}

TEST(Certificate, OneFlippedFace) {
  // Vertex 0 pushed over the opposite edge of one of its faces: that one flips, and the sum of the
  // angles does not tell.
  const Mesh mesh = icosphereMesh(3);
  for (int f = 0; f < mesh.faces.rows(); f += 7) {
    Points positions = mesh.vertices;
    const int v = mesh.faces(f, 0);
    const Eigen::RowVector3d middle =
        (positions.row(mesh.faces(f, 1)) + positions.row(mesh.faces(f, 2))) / 2;
    positions.row(v) = (positions.row(v) + 1.02 * (middle - positions.row(v))).normalized();
    const Certificate certificate = certify(mesh.faces, positions);
    EXPECT_FALSE(certificate.valid());
    EXPECT_EQ(certificate.flippedFaces, 1);
    EXPECT_EQ(certificate.firstFlippedFace, f);
    EXPECT_NEAR(certificate.degree, 1, 1e-12);
    EXPECT_NE(certificate.reason().find("1 face is flipped on the sphere, the first is face " +
                                        std::to_string(f)),
              std::string::npos)
        << certificate.reason();
  }
}

TEST(Certificate, InsideOut) {
  const Mesh mesh = icosphereMesh(2);
  const Certificate certificate = certify(mesh.faces, -mesh.vertices);
  EXPECT_FALSE(certificate.valid());
  EXPECT_EQ(certificate.flippedFaces, 80);
  EXPECT_EQ(certificate.firstFlippedFace, 0);
  EXPECT_NEAR(certificate.degree, -1, 1e-12);
}

TEST(Certificate, DoubleCover) {
  // A bipyramid whose equator runs several times round: closed, of genus 0, every face positive.
  // Only the degree tells.
  for (const int sheets : {2, 3}) {
    const int sides = 5 * sheets;
    const Mesh mesh = bipyramid(sides);
    EXPECT_NO_THROW(ClosedSurface(mesh.vertices, mesh.faces));
    Points positions = mesh.vertices;
    for (int i = 0; i < sides; ++i) {
      const double longitude = 2 * pi * sheets * i / sides;
      positions.row(2 + i) << std::cos(longitude), std::sin(longitude), 0;
    }
    const Certificate certificate = certify(mesh.faces, positions);
    EXPECT_EQ(certificate.flippedFaces, 0);
    EXPECT_EQ(certificate.notOnSphere, 0);
    EXPECT_NEAR(certificate.degree, sheets, 1e-12);
    EXPECT_FALSE(certificate.valid());
    EXPECT_NE(certificate.reason().find(std::to_string(sheets) + " times"), std::string::npos)
        << certificate.reason();
  }
}

TEST(Certificate, AllInOnePlace) {
  const Mesh mesh = icosahedron();
  Points positions(12, 3);
  positions.rowwise() = Eigen::RowVector3d(0, 0, 1);
  const Certificate certificate = certify(mesh.faces, positions);
  EXPECT_FALSE(certificate.valid());
  EXPECT_EQ(certificate.flippedFaces, 20);
  EXPECT_NEAR(certificate.degree, 0, 1e-15);
}

TEST(Certificate, AntipodalEdge) {
  // The faces at an edge between antipodes are not defined: neither is positive.
  const Mesh mesh = bipyramid(4);
  Points positions = mesh.vertices;
  positions.row(3) = -positions.row(2);
  const Certificate certificate = certify(mesh.faces, positions);
  EXPECT_FALSE(certificate.valid());
  EXPECT_GE(certificate.flippedFaces, 2);
  EXPECT_EQ(certificate.firstFlippedFace, 0);
}

TEST(Certificate, NotOnTheSphere) {
  const Mesh mesh = icosphereMesh(2);
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               inf = std::numeric_limits<double>::infinity();
  for (const Eigen::RowVector3d& bad :
       {Eigen::RowVector3d(nan, 0, 1), Eigen::RowVector3d(0, nan, 0), Eigen::RowVector3d(inf, 0, 0),
        Eigen::RowVector3d(0, 0, 0), Eigen::RowVector3d(0, 0, -inf),
        Eigen::RowVector3d(1e200, 1e200, 0)}) {
    Points positions = mesh.vertices;
    positions.row(7) = bad;
    positions.row(30) = bad;
    const Certificate certificate = certify(mesh.faces, positions);
    EXPECT_FALSE(certificate.valid());
    EXPECT_EQ(certificate.notOnSphere, 2);
    EXPECT_EQ(certificate.firstNotOnSphere, 7);
    EXPECT_GE(certificate.flippedFaces, 10);  // the faces there count as well
    EXPECT_NE(certificate.reason().find(
                  "2 vertices do not lie on the unit sphere, the first is vertex 7"),
              std::string::npos)
        << certificate.reason();
  }
  for (const double length : {1 + 2e-6, 1 - 2e-6}) {
    Points positions = mesh.vertices;
    positions.row(4) *= length;
    EXPECT_EQ(certify(mesh.faces, positions).notOnSphere, 1);
  }
  for (const double length : {1 + 9e-7, 1 - 9e-7})
    EXPECT_TRUE(certify(mesh.faces, length * mesh.vertices).valid());
}

TEST(Certificate, NoFaces) {
  EXPECT_FALSE(certify(Triangles(0, 3), octahedron().vertices).valid());
}

/// Three points on one great circle of the plane of u and w, exactly: integer multiples of u and w
/// over 2^26, about unit vectors. Their determinant is 0, which rounded arithmetic does not see.
Eigen::Matrix3d onGreatCircle(double from) {
  const Vector3 u(1, 2, 2), w(2, 1, -2);  // orthogonal, both of length 3
  Eigen::Matrix3d points;
  for (int k = 0; k < 3; ++k) {
    const double angle = from + 2 * pi * k / 3, radius = 0x1p26 / 3;
    points.col(k) = 0x1p-26 * (std::round(radius * std::cos(angle)) * u +
                               std::round(radius * std::sin(angle)) * w);
  }
  return points;
}

TEST(Certificate, HemisphereThatOnlyExactArithmeticTells) {
  // A tetrahedron with three corners on a great circle: its base is a hemisphere, positive if one
  // of the three is moved by a unit in the last place to one side, the complement (hence flipped)
  // if to the other or not at all.
  const Triangles faces{{0, 1, 2}, {3, 1, 0}, {3, 2, 1}, {3, 0, 2}};
  int roundedWrongly = 0;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Matrix3d corners = onGreatCircle(0.004 + 0.013 * i);
    for (int k = 0; k < 3; ++k) ASSERT_NEAR(corners.col(k).norm(), 1, 5e-7);
    Points positions(4, 3);
    positions << corners.transpose(),
        Eigen::RowVector3d(2, -2, 1) / 3;  // the apex is at the pole w x u of the plane
    const Vector3 normal(-2, 2, -1);       // u x w, on the other side
    ASSERT_EQ(normal.dot(corners.col(0)), 0);

    const double det = corners.col(0).dot(corners.col(1).cross(corners.col(2)));
    roundedWrongly += det != 0;
    EXPECT_FALSE(certify(faces, positions).valid());
    EXPECT_EQ(certify(faces, positions).flippedFaces, 1);

    for (const double side : {1.0, -1.0})
      for (int axis = 0; axis < 3; ++axis) {
        Points moved = positions;
        moved(1, axis) = std::nextafter(moved(1, axis), side * normal[axis] > 0 ? 2.0 : -2.0);
        const Certificate certificate = certify(faces, moved);
        EXPECT_EQ(certificate.flippedFaces, side > 0 ? 0 : 1)
            << "circle " << i << ", axis " << axis;
        EXPECT_EQ(certificate.valid(), side > 0) << certificate.reason();
        EXPECT_NEAR(certificate.degree, side > 0 ? 1 : 0, 1e-6);
      }
  }
  EXPECT_GT(roundedWrongly, 100);  // else this test shows nothing
}

TEST(Certificate, HemisphereToTheSmallestNumber) {
  // Three corners on the equator, one of them lifted by as little as a double can hold: products of
  // the filter underflow.
  const Triangles faces{{0, 1, 2}, {3, 1, 0}, {3, 2, 1}, {3, 0, 2}};
  Points positions(4, 3);
  positions << 1, 0, 0, -0.5, std::sqrt(0.75), 0, -0.5, -std::sqrt(0.75), 0, 0, 0, -1;
  for (const double height : {5e-324, 1e-310, 1e-200, 1e-30, 1e-16}) {
    positions(1, 2) = height;
    EXPECT_TRUE(certify(faces, positions).valid()) << height;
    positions(1, 2) = -height;
    EXPECT_EQ(certify(faces, positions).flippedFaces, 1) << height;
  }
}

TEST(Certificate, SolidAngleTooSmall) {
  // Positive in exact arithmetic, but too small to be told from a point: the 8 faces of the
  // innermost ring (0.354 r^2) and the 16 of the next.
  const Mesh mesh = rings(1e-7);
  const Certificate certificate = certify(mesh.faces, mesh.vertices);
  EXPECT_EQ(certificate.flippedFaces, 24);
  EXPECT_EQ(certificate.firstFlippedFace, 0);
  EXPECT_FALSE(certificate.valid());
  EXPECT_NEAR(certificate.degree, 1, 1e-12);
  const Mesh larger = rings(2e-7);  // 0.354 r^2 = 1.4e-14
  EXPECT_TRUE(certify(larger.faces, larger.vertices).valid());
}

TEST(Certificate, MapsRoundedToFloat) {
  const auto rounded = [](const Mesh& mesh) {
    return Points(mesh.vertices.cast<float>().cast<double>());
  };
  const Mesh regular = transformed(icosphereMesh(10), randomRotation(1), 1, Vector3::Zero());
  EXPECT_TRUE(certify(regular.faces, rounded(regular)).valid());
  const Mesh fine = transformed(rings(1.7e-7), randomRotation(1), 1, Vector3::Zero());
  ASSERT_TRUE(certify(fine.faces, fine.vertices).valid());
  const Certificate certificate =
      certify(fine.faces, rounded(fine));  // where floats are 6e-8 apart
  EXPECT_FALSE(certificate.valid());
  EXPECT_EQ(certificate.notOnSphere, 0);
  EXPECT_GT(certificate.flippedFaces, 0);
}

}  // namespace
}  // namespace sphere_propagation::test
