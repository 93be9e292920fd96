// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/mapped_surface.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/core/test_meshes.h"
#include "vcg_ext/sphere/sphere_walk.h"

namespace sphere_propagation::test {
namespace {

MapError errorOf(const ClosedSurface& surface, const Points& positions) {
  try {
    const MappedSurface map(surface, positions);
  } catch (const MapError& error) {
    EXPECT_EQ(error.finding().name, "phase 3");
    return error;
  }
  ADD_FAILURE() << "the positions were accepted";
  return MapError("accepted");
}

TEST(MappedSurface, KeepsValidPositions) {
  const Mesh mesh = noisyEllipsoid(1), sphere = icosphereMesh(8);
  const ClosedSurface surface(mesh.vertices, mesh.faces, "phase 3");
  const MappedSurface map(surface, sphere.vertices);
  EXPECT_EQ(map.positions(), sphere.vertices);
  EXPECT_EQ(map.position(5), Vector3(sphere.vertices.row(5).transpose()));
}

TEST(MappedSurface, NamesWhatIsWrong) {
  const Mesh mesh = icosphereMesh(2);
  const ClosedSurface surface(mesh.vertices, mesh.faces, "phase 3");

  const MapError few = errorOf(surface, mesh.vertices.topRows(41));
  EXPECT_EQ(few.fault(), Fault::PositionCount);
  EXPECT_EQ(few.finding().count, 41);
  EXPECT_EQ(few.finding().others, 42);

  // Vertices off the sphere and flipped faces are counted apart.
  Points both = -mesh.vertices;
  both.row(17) *= 1.1;
  const MapError first = errorOf(surface, both);
  EXPECT_EQ(first.fault(), Fault::NotOnSphere);
  EXPECT_EQ(first.finding().count, 1);
  EXPECT_EQ(first.finding().first, 17);

  const MapError insideOut = errorOf(surface, -mesh.vertices);
  EXPECT_EQ(insideOut.fault(), Fault::FlippedFaces);
  EXPECT_EQ(insideOut.finding().count, 80);
  EXPECT_EQ(insideOut.finding().first, 0);

  Points positions = mesh.vertices;
  positions.row(9) *= 1.1;
  const MapError offSphere = errorOf(surface, positions);
  EXPECT_EQ(offSphere.finding().first, 9);
  EXPECT_EQ(std::string(offSphere.what()),
            "Surface \"phase 3\": its map to the sphere is not valid: 1 vertex does not lie on the "
            "unit sphere, the first is vertex 9.");
}

TEST(MappedSurface, IsOfEverySurfaceWithItsFaces) {
  const Mesh mesh = icosphereMesh(3);
  const ClosedSurface surface(mesh.vertices, mesh.faces, "here");
  const MappedSurface map(surface, mesh.vertices);
  const MappedSurface moved = map.of(surface.withVertices(2 * mesh.vertices));
  EXPECT_EQ(moved.surface().vertex(4), 2 * surface.vertex(4));
  EXPECT_EQ(moved.positions().data(), map.positions().data());  // shared
  EXPECT_EQ(map.of(ClosedSurface(mesh.vertices, mesh.faces)).positions(), map.positions());

  // As many vertices, but other faces.
  Triangles turned = mesh.faces;
  turned.row(0).swap(turned.row(1));
  EXPECT_THROW(map.of(ClosedSurface(mesh.vertices, turned)), ParameterError);
  EXPECT_THROW(map.of(ClosedSurface(octahedron().vertices, octahedron().faces)), ParameterError);
}

TEST(MappedSurface, OutlivesWhatItWasMadeFrom) {
  std::optional<MappedSurface> map;
  {
    const Mesh mesh = icosphereMesh(2);
    map.emplace(ClosedSurface(mesh.vertices, mesh.faces, "gone"), mesh.vertices);
  }
  SphereWalk walk(*map);
  map.reset();
  EXPECT_GE(walk.locate(Vector3(1, 2, 3)).face, 0);
}

}  // namespace
}  // namespace sphere_propagation::test
