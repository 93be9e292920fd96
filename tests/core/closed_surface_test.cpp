// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/closed_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>
#include <string>

#include "tests/core/test_meshes.h"

namespace sphere_propagation::test {
namespace {

/// The error that a mesh causes; fails the test if there is none.
SurfaceError errorOf(const Mesh& mesh) {
  try {
    const ClosedSurface surface(mesh.vertices, mesh.faces, "systole 7");
  } catch (const SurfaceError& error) {
    return error;
  }
  ADD_FAILURE() << "the mesh was accepted";
  return SurfaceError("accepted");
}

/// words: what the text says of the surface that it names.
void expectFault(const Mesh& mesh, Fault fault, long count, long first, const std::string& words) {
  const SurfaceError error = errorOf(mesh);
  EXPECT_EQ(nameOf(error.fault()), nameOf(fault)) << error.what();
  EXPECT_EQ(error.finding().count, count) << error.what();
  EXPECT_EQ(error.finding().first, first) << error.what();
  EXPECT_EQ(error.finding().name, "systole 7");
  EXPECT_EQ(error.what(), "Surface \"systole 7\": " + words + ".");
}

TEST(ClosedSurface, EveryFaultHasItsError) {
  expectFault({Points(0, 3), Triangles(0, 3)}, Fault::Empty, 0, -1, "it is empty");
  expectFault({octahedron().vertices, Triangles(0, 3)}, Fault::NoFaces, 0, -1,
              "it has vertices but no faces");
  expectFault({octahedron().vertices.topRows(3), Triangles{{0, 1, 2}, {0, 2, 1}}},
              Fault::TooFewVertices, 3, 0, "it has 3 vertices");
  expectFault(withNaN(), Fault::NonFiniteCoordinate, 1, 5,
              "1 vertex has coordinates that are not finite numbers, the first is vertex 5");
  expectFault(withDegenerateFace(), Fault::DegenerateFace, 1, 20,
              "1 face uses one vertex twice, the first is face 20");
  expectFault(nonManifoldEdge(), Fault::NonManifoldEdge, 1, 0,
              "1 edge has more than two faces, the first at face 0");
  expectFault(openCone(), Fault::NotClosed, 8, 0,
              "it is not closed: 8 edges have a face on one side only, the first at face 0; they "
              "surround 1 opening, the largest of 8 edges");
  expectFault(flippedFace(), Fault::InconsistentOrientation, 3, 4,
              "its faces are not oriented alike: 3 edges lie between faces of opposite "
              "orientation, the first at face 4");
  expectFault(withUnreferencedVertex(), Fault::UnreferencedVertex, 1, 12,
              "1 vertex belongs to no face, the first is vertex 12");
  expectFault(nonManifoldVertex(), Fault::NonManifoldVertex, 1, 0,
              "at 1 vertex sheets touch that share no edge there, the first is vertex 0");
  expectFault(twoSpheres(), Fault::SeveralParts, 2, 6,
              "it has 2 separate parts, vertex 6 is the first outside the part of vertex 0");
  expectFault(torus(), Fault::Handles, 1, -1, "it has 1 handle (genus 1), and a sphere has none");
  expectFault(inwardSphere(), Fault::InwardOrientation, 20, 0, "its faces are oriented inwards");
}

TEST(ClosedSurface, SeveralOfOneFault) {
  Mesh mesh = icosahedron();
  mesh.vertices(9, 0) = std::numeric_limits<double>::infinity();
  mesh.vertices(3, 2) = -std::numeric_limits<double>::quiet_NaN();
  expectFault(mesh, Fault::NonFiniteCoordinate, 2, 3,
              "2 vertices have coordinates that are not finite numbers, the first is vertex 3");

  mesh = icosahedron();
  mesh.faces(11, 1) = 12;
  mesh.faces(15, 2) = -1;
  expectFault(mesh, Fault::IndexOutOfRange, 2, 11,
              "2 faces refer to vertices that do not exist, the first is face 11");

  mesh = icosahedron();  // a face twice: three faces at each of its edges
  mesh.faces.conservativeResize(21, 3);
  mesh.faces.row(20) = mesh.faces.row(4);
  EXPECT_EQ(errorOf(mesh).fault(), Fault::NonManifoldEdge);
  EXPECT_EQ(errorOf(mesh).finding().count, 3);

  mesh = icosahedron();
  mesh.vertices.setConstant(3.5);
  expectFault(mesh, Fault::ZeroArea, 20, 0, "all its faces have zero area");

  mesh = icosahedron();  // a hole of one face
  mesh.faces = Triangles(mesh.faces.topRows(19));
  EXPECT_EQ(errorOf(mesh).fault(), Fault::NotClosed);
  EXPECT_EQ(errorOf(mesh).finding().count, 3);
}

TEST(ClosedSurface, OpeningsAreCountedAndMeasured) {
  // One face is gone, and all around a vertex that shares none with it.
  Mesh mesh = icosahedron();
  const int apex = mesh.faces(0, 0);
  Triangles kept(mesh.faces.rows(), 3);
  int count = 0, single = -1;
  for (int f = 0; f < mesh.faces.rows(); ++f) {
    if ((mesh.faces.row(f).array() == apex).any()) continue;
    kept.row(count++) = mesh.faces.row(f);
  }
  const auto touchesRing = [&](int f) {
    for (int g = 0; g < mesh.faces.rows(); ++g)
      if ((mesh.faces.row(g).array() == apex).any())
        for (int k = 0; k < 3; ++k)
          if ((kept.row(f).array() == mesh.faces(g, k)).any()) return true;
    return false;
  };
  for (int f = 0; f < count && single < 0; ++f)
    if (!touchesRing(f)) single = f;
  ASSERT_GE(single, 0);
  kept.row(single) = kept.row(count - 1);
  mesh.faces = kept.topRows(count - 1);
  EXPECT_EQ(errorOf(mesh).finding().count, 8);
  EXPECT_EQ(errorOf(mesh).finding().others, 2);
  EXPECT_EQ(errorOf(mesh).finding().value, 5);

  // The same where faces are not oriented alike, and where two openings meet in a vertex.
  for (int f = 0; f < mesh.faces.rows(); f += 2) std::swap(mesh.faces(f, 1), mesh.faces(f, 2));
  EXPECT_EQ(errorOf(mesh).finding().others, 2);
  EXPECT_EQ(errorOf(mesh).finding().value, 5);
  mesh = octahedron();  // two faces that share nothing but a vertex
  Triangles rest(6, 3);
  count = 0;
  int opposite = -1;
  for (int f = 1; f < 8 && opposite < 0; ++f) {
    int shared = 0;
    for (int k = 0; k < 3; ++k) shared += (mesh.faces.row(0).array() == mesh.faces(f, k)).any();
    if (shared == 1) opposite = f;
  }
  for (int f = 1; f < 8; ++f)
    if (f != opposite) rest.row(count++) = mesh.faces.row(f);
  mesh.faces = rest;
  EXPECT_EQ(errorOf(mesh).finding().others, 1);  // one way round both, as MeshLab goes it
  EXPECT_EQ(errorOf(mesh).finding().value, 6);
}

TEST(ClosedSurface, FaceSoupIsToldFromAHole) {
  const SurfaceError error = errorOf(duplicatedVertices());
  EXPECT_EQ(error.fault(), Fault::NotWelded);
  EXPECT_EQ(error.finding().count, 60);
  EXPECT_EQ(error.finding().others, 48);
  EXPECT_EQ(std::string(error.what()),
            "Surface \"systole 7\": it is not closed: 60 edges have a face on one side only, the "
            "first at face 0. 48 vertices lie exactly where another one lies.");
}

TEST(ClosedSurface, GenusIsCounted) {
  // Two tori that share a face's place: cut one face from each and join the holes.
  const Mesh one = torus();
  const int n = static_cast<int>(one.vertices.rows()), m = static_cast<int>(one.faces.rows());
  Mesh two;
  two.vertices.resize(2 * n, 3);
  two.vertices << one.vertices, (one.vertices.rowwise() + Eigen::RowVector3d(9, 0, 0));
  two.faces.resize(2 * m - 2 + 6, 3);
  two.faces << one.faces.topRows(m - 1), (one.faces.topRows(m - 1).array() + n).matrix(),
      Triangles::Zero(6, 3);
  for (int k = 0; k < 3; ++k) {  // the two holes face each other when one runs the other way
    const int a = one.faces(m - 1, k), b = one.faces(m - 1, (k + 1) % 3);
    const int c = n + one.faces(m - 1, (3 - k) % 3), d = n + one.faces(m - 1, (5 - k) % 3);
    two.faces.row(2 * m - 2 + 2 * k) << a, b, c;
    two.faces.row(2 * m - 2 + 2 * k + 1) << b, d, c;
  }
  const SurfaceError error = errorOf(two);
  EXPECT_EQ(error.fault(), Fault::Handles) << error.what();
  EXPECT_EQ(error.finding().count, 2);
}

TEST(ClosedSurface, Accepted) {
  for (const Mesh& mesh :
       {tetrahedron(), octahedron(), icosahedron(), icosphereMesh(5), noisyEllipsoid(1),
        bipyramid(3), bipyramid(50), withZeroAreaFace(), rings(1e-6)})
    EXPECT_NO_THROW(ClosedSurface(mesh.vertices, mesh.faces));
}

TEST(ClosedSurface, AnyScaleAndFlattened) {
  for (const double scale : {1e-30, 1e-3, 1e30}) {
    Mesh mesh = ellipsoid(3, 2, 1, 3);
    mesh.vertices *= scale;
    EXPECT_NO_THROW(ClosedSurface(mesh.vertices, mesh.faces)) << scale;
    for (int f = 0; f < mesh.faces.rows(); ++f) std::swap(mesh.faces(f, 0), mesh.faces(f, 1));
    EXPECT_EQ(errorOf(mesh).fault(), Fault::InwardOrientation) << scale;
    mesh.vertices.col(2).setZero();
    EXPECT_NO_THROW(ClosedSurface(mesh.vertices, mesh.faces)) << "flat, " << scale;
  }
  Mesh far = ellipsoid(3, 2, 1, 3);  // a thousandth of a millimetre, a kilometre away
  far.vertices = ((far.vertices * 1e-3).rowwise() + Eigen::RowVector3d(1e6, 1e6, 1e6)).eval();
  EXPECT_NO_THROW(ClosedSurface(far.vertices, far.faces));
}

TEST(ClosedSurface, TwinsAreInvolutions) {
  for (const Mesh& mesh : {tetrahedron(), noisyEllipsoid(2), withZeroAreaFace()}) {
    const ClosedSurface surface(mesh.vertices, mesh.faces);
    for (int h = 0; h < 3 * surface.faceCount(); ++h) {
      const int t = surface.twin(h);
      EXPECT_NE(t, h);
      EXPECT_EQ(surface.twin(t), h);
      EXPECT_EQ(surface.origin(t), surface.target(h));
      EXPECT_EQ(surface.target(t), surface.origin(h));
      EXPECT_EQ(ClosedSurface::previous(ClosedSurface::next(h)), h);
      EXPECT_EQ(ClosedSurface::next(h) / 3, h / 3);
    }
    EXPECT_EQ(surface.vertexCount() - 3 * surface.faceCount() / 2 + surface.faceCount(), 2);
  }
}

TEST(ClosedSurface, RingsAreCounterClockwiseAndComplete) {
  for (const Mesh& mesh :
       {tetrahedron(), octahedron(), icosphereMesh(4), noisyEllipsoid(3), bipyramid(9)}) {
    const ClosedSurface surface(mesh.vertices, mesh.faces);
    std::vector<std::set<int>> neighbours(static_cast<size_t>(surface.vertexCount()));
    for (int f = 0; f < surface.faceCount(); ++f)
      for (int k = 0; k < 3; ++k) {
        neighbours[static_cast<size_t>(mesh.faces(f, k))].insert(mesh.faces(f, (k + 1) % 3));
        neighbours[static_cast<size_t>(mesh.faces(f, k))].insert(mesh.faces(f, (k + 2) % 3));
      }
    for (int v = 0; v < surface.vertexCount(); ++v) {
      const IndexRange ring = surface.ring(v), outgoing = surface.outgoing(v);
      ASSERT_EQ(ring.size(), outgoing.size());
      const std::set<int> found(ring.begin(), ring.end());
      EXPECT_EQ(found, neighbours[static_cast<size_t>(v)]);
      EXPECT_EQ(static_cast<int>(found.size()), ring.size());  // none twice
      for (int i = 0; i < ring.size(); ++i) {
        const int h = outgoing[i], next = ring[(i + 1) % ring.size()];
        EXPECT_EQ(surface.origin(h), v);
        EXPECT_EQ(surface.target(h), ring[i]);
        EXPECT_EQ(surface.target(ClosedSurface::next(h)),
                  next);  // face (v, ring[i], ring[i + 1]) as it is stored
      }
    }
  }
}

TEST(ClosedSurface, WithVerticesSharesTheConnectivity) {
  const Mesh mesh = test::icosphereMesh(3);
  const ClosedSurface surface = surfaceOf(mesh, "phase 3");
  const ClosedSurface larger = surface.withVertices(2 * mesh.vertices);
  EXPECT_EQ(larger.faces().data(), surface.faces().data());
  EXPECT_EQ(larger.vertices(), 2 * mesh.vertices);
  EXPECT_EQ(larger.name(), "phase 3");
  EXPECT_TRUE(larger.hasFacesOf(surface));
  EXPECT_FALSE(surface.hasFacesOf(surfaceOf(test::octahedron())));

  EXPECT_THROW(surface.withVertices(mesh.vertices.topRows(41)), ParameterError);
  EXPECT_THROW(surface.withVertices(-mesh.vertices), SurfaceError);     // inside out
  EXPECT_THROW(surface.withVertices(0 * mesh.vertices), SurfaceError);  // no area
  Points broken = mesh.vertices;
  broken(7, 1) = std::numeric_limits<double>::quiet_NaN();
  try {
    surface.withVertices(broken);
    FAIL() << "no error";
  } catch (const SurfaceError& error) {
    EXPECT_EQ(error.fault(), Fault::NonFiniteCoordinate);
    EXPECT_EQ(error.finding().first, 7);
  }
}

}  // namespace
}  // namespace sphere_propagation::test
