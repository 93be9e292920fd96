// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/sphere_locator.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "tests/core/test_meshes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/sphere/certificate.h"
#include "vcg_ext/sphere/sphere_walk.h"

namespace sphere_propagation::test {
namespace {

/// A mesh on the sphere, mapped to itself.
struct Located {
  ClosedSurface surface;
  MappedSurface map;
  SphereLocator locator;
  explicit Located(const Mesh& mesh)
      : surface(mesh.vertices, mesh.faces), map(surface, mesh.vertices), locator(map) {}

  Vector3 at(const SurfacePoint& p) const {
    return p.interpolate(surface.faces(), map.positions());
  }
};

void expectHit(const Located& sphere, const Vector3& direction, double tolerance = 1e-14) {
  const SurfacePoint found = sphere.locator.locate(direction);
  ASSERT_GE(found.face, 0);
  EXPECT_GE(found.weights.minCoeff(), 0);
  EXPECT_NEAR(found.weights.sum(), 1, 1e-14);
  EXPECT_LT((sphere.at(found).normalized() - direction.normalized()).norm(), tolerance);
}

TEST(SphereLocator, EveryVertexMidpointAndCentroid) {
  for (const Mesh& mesh :
       {tetrahedron(), octahedron(), icosahedron(), icosphereMesh(3), icosphereMesh(10)})
    for (const unsigned seed : {0U, 1U, 2U}) {
      const Located sphere(seed == 0 ? mesh
                                     : transformed(mesh, randomRotation(seed), 1, Vector3::Zero()));
      for (int v = 0; v < sphere.surface.vertexCount(); ++v) {
        const Vector3 p = sphere.map.position(v);
        expectHit(sphere, p);
        const SurfacePoint found = sphere.locator.locate(p);
        EXPECT_TRUE((sphere.surface.faces().row(found.face).array() == v).any());
        EXPECT_NEAR(found.weights.maxCoeff(), 1, 1e-14);
      }
      for (int f = 0; f < sphere.surface.faceCount(); ++f) {
        Vector3 p[3];
        for (int k = 0; k < 3; ++k) p[k] = sphere.map.position(sphere.surface.faces()(f, k));
        for (int k = 0; k < 3; ++k) expectHit(sphere, p[k] + p[(k + 1) % 3]);
        const SurfacePoint found = sphere.locator.locate(p[0] + p[1] + p[2]);
        EXPECT_EQ(found.face, f);
        EXPECT_LT((found.weights - Vector3::Constant(1.0 / 3)).norm(), 1e-13);
      }
    }
}

TEST(SphereLocator, AgreesWithBruteForce) {
  const Located sphere(transformed(icosphereMesh(6), randomRotation(3), 1, Vector3::Zero()));
  Random random(17);
  for (int i = 0; i < 1000; ++i) {
    const Vector3 p = random.direction();
    int hit = -1;
    for (int f = 0; f < sphere.surface.faceCount() && hit < 0; ++f) {
      Eigen::Matrix3d corners;
      for (int k = 0; k < 3; ++k)
        corners.col(k) = sphere.map.position(sphere.surface.faces()(f, k));
      if ((corners.inverse() * p).minCoeff() >= 0) hit = f;
    }
    EXPECT_EQ(sphere.locator.locate(p).face, hit);
    expectHit(sphere, p);
  }
}

TEST(SphereLocator, AxesAndDirectionsBesideThem) {
  const double tiny = std::numeric_limits<double>::denorm_min();
  for (const Mesh& mesh : {octahedron(), icosphereMesh(4),
                           transformed(octahedron(), randomRotation(9), 1, {0, 0, 0})}) {
    const Located sphere(mesh);
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {-1.0, 1.0})
        for (const double beside : {0.0, tiny, -tiny, 1e-200, 1e-17, -1e-17, 1e-12, -1e-9}) {
          Vector3 p = Vector3::Constant(beside);
          p[axis] = sign;
          expectHit(sphere, p);
        }
  }
}

TEST(SphereLocator, TinyAndHugeFaces) {
  const Mesh mesh = transformed(rings(1e-6), randomRotation(5), 1, Vector3::Zero());
  const Certificate certificate = certify(mesh.faces, mesh.vertices);
  ASSERT_TRUE(certificate.valid()) << certificate.reason();
  const Located sphere(mesh);
  double smallest = 1;
  for (int f = 0; f < sphere.surface.faceCount(); ++f) {
    Vector3 p[3];
    for (int k = 0; k < 3; ++k) p[k] = sphere.map.position(sphere.surface.faces()(f, k));
    smallest = std::min(smallest, (p[1] - p[0]).cross(p[2] - p[0]).norm() / 2);
    const Vector3 centroid = p[0] + p[1] + p[2];
    EXPECT_EQ(sphere.locator.locate(centroid).face, f);
    for (int k = 0; k < 3; ++k) expectHit(sphere, p[k] + p[(k + 1) % 3], 1e-13);
  }
  EXPECT_LT(smallest, 1e-12);
  Random random(19);
  for (int i = 0; i < 2000; ++i) {
    expectHit(sphere, random.direction(), 1e-12);
    const Vector3 pole = mesh.vertices.row(0).transpose();
    expectHit(sphere, pole + 1e-5 * random.uniform() * random.direction(), 1e-13);
  }
}

TEST(SphereLocator, NearlyAHemisphere) {
  // A tetrahedron whose base is all but a hemisphere, and three thin faces beside the equator.
  // The flat base passes the centre at that height: a rounding of its weights turns the direction
  // by as much more.
  for (const double height : {1e-3, 1e-7, 1e-10}) {
    Mesh mesh = tetrahedron();
    mesh.vertices.row(0) << 0, 0, -1;
    const double turn = 2 * 3.14159265358979323846 / 3;
    for (int k = 0; k < 3; ++k)
      mesh.vertices.row(1 + k) << std::cos(turn * k), std::sin(turn * k), height;
    mesh.vertices.rowwise().normalize();
    mesh.faces << 1, 2, 3, 0, 2, 1, 0, 3, 2, 0, 1, 3;
    const Located sphere(mesh);
    EXPECT_EQ(sphere.locator.locate({0, 0, 1}).face, 0);
    EXPECT_NE(sphere.locator.locate({0.3, 0.2, -0.1}).face, 0);
    Random random(23);
    for (int i = 0; i < 500; ++i) expectHit(sphere, random.direction(), 2e-15 / height);
    for (int i = 0; i < 500; ++i)
      expectHit(sphere, Vector3(random.normal(), random.normal(), height * random.normal()),
                2e-15 / height);
  }
}

TEST(SphereLocator, MapRoundedToFloat) {
  Mesh mesh = transformed(icosphereMesh(8), randomRotation(31), 1, Vector3::Zero());
  mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
  const Located sphere(mesh);
  for (int v = 0; v < sphere.surface.vertexCount(); ++v) expectHit(sphere, sphere.map.position(v));
  Random random(29);
  for (int i = 0; i < 1000; ++i) expectHit(sphere, random.direction());
}

TEST(SphereLocator, LengthOfTheDirectionDoesNotMatter) {
  const Located sphere(icosphereMesh(5));
  const Vector3 p(0.3, -0.2, 0.7);
  const SurfacePoint found = sphere.locator.locate(p);
  for (const double scale : {1e-300, 1e-20, 1e20, 1e300}) {
    const SurfacePoint other = sphere.locator.locate(scale * p);
    EXPECT_EQ(other.face, found.face);
    EXPECT_LT((other.weights - found.weights).norm(), 1e-13);
  }
}

TEST(SphereLocator, SmallestIndexAtAVertex) {
  const Located sphere(octahedron());
  for (int v = 0; v < 6; ++v) {
    int first = 0;
    while ((sphere.surface.faces().row(first).array() != v).all()) ++first;
    EXPECT_EQ(sphere.locator.locate(sphere.map.position(v)).face, first);
  }
}

TEST(SphereWalk, AnswersAsTheLocatorDoes) {
  Mesh turned = transformed(icosphereMesh(9), randomRotation(3), 1, Vector3::Zero());
  for (const Mesh& mesh : {octahedron(), icosphereMesh(10), turned,
                           transformed(rings(1e-6), randomRotation(5), 1, {0, 0, 0})}) {
    const Located sphere(mesh);
    SphereWalk walk(sphere.map);
    const auto expectSame = [&](const Vector3& p) {
      const SurfacePoint found = walk.locate(p), expected = sphere.locator.locate(p);
      EXPECT_EQ(found.face, expected.face);
      EXPECT_EQ(found.weights, expected.weights);  // bit for bit
    };
    const Icosphere directions =
        icosphere(10);  // each near the one before; vertices, edges and faces of one mesh
    for (Eigen::Index j = 0; j < directions.vertices.rows(); ++j)
      expectSame(directions.vertices.row(j).transpose());
    Random random(7);
    for (int i = 0; i < 500; ++i) expectSame(3 * random.direction());  // from anywhere to anywhere
    EXPECT_THROW(walk.locate(Vector3::Zero()), ParameterError);
  }
}

TEST(SphereWalk, EndsInTheFaceUnderTheDirection) {
  const Located sphere(transformed(icosphereMesh(12), randomRotation(8), 1, Vector3::Zero()));
  Random random(11);
  for (int i = 0; i < 300; ++i) {
    const Vector3 p = random.direction();
    const int start = random.index(sphere.surface.faceCount());
    EXPECT_EQ(walkOverSphere(sphere.map, p, start), sphere.locator.locate(p).face);
  }
}

TEST(SphereLocator, AnswersEveryDirectionAtTheLimitOfWhatIsValid) {
  // The base passes the centre closer than a query is rounded.
  for (const double height : {1e-12, 1e-13}) {
    Mesh mesh = tetrahedron();
    mesh.vertices.row(0) << 0, 0, -1;
    const double turn = 2 * 3.14159265358979323846 / 3;
    for (int k = 0; k < 3; ++k)
      mesh.vertices.row(1 + k) << std::cos(turn * k), std::sin(turn * k), height;
    mesh.faces << 1, 2, 3, 0, 2, 1, 0, 3, 2, 0, 1, 3;
    ASSERT_TRUE(certify(mesh.faces, mesh.vertices).valid());
    const Located sphere(mesh);
    Random random(29);
    for (int i = 0; i < 2000; ++i)
      for (const double flat : {1.0, height, 1e-3 * height, 0.0}) {
        const SurfacePoint found =
            sphere.locator.locate({random.normal(), random.normal(), flat * random.normal()});
        ASSERT_GE(found.face, 0);
        ASSERT_NEAR(found.weights.sum(), 1, 1e-12);
        ASSERT_GE(found.weights.minCoeff(), 0);
      }
  }
}

TEST(SphereLocator, NoDirection) {
  const Located sphere(octahedron());
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               inf = std::numeric_limits<double>::infinity();
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(nan, 0, 1), Vector3(inf, 0, 0)})
    EXPECT_THROW(sphere.locator.locate(p), ParameterError);
}

}  // namespace
}  // namespace sphere_propagation::test
