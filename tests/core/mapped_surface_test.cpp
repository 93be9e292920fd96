// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/sphere_map.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/core/test_meshes.h"

namespace sphere_propagation::test {
namespace {

MapError errorOf(const ClosedSurface& surface, const Points& positions) {
  try {
    const SphereMap map(surface, positions);
  } catch (const MapError& error) {
    EXPECT_NE(std::string(error.what()).find("Layer \"phase 3\""), std::string::npos)
        << error.what();
    return error;
  }
  ADD_FAILURE() << "the positions were accepted";
  return {-2, -2, ""};
}

TEST(SphereMap, KeepsValidPositions) {
  const Mesh mesh = noisyEllipsoid(1), sphere = icosphereMesh(8);
  const ClosedSurface surface(mesh.vertices, mesh.faces, "phase 3");
  const SphereMap map(surface, sphere.vertices);
  EXPECT_EQ(map.positions(), sphere.vertices);
  EXPECT_EQ(map.position(5), Vector3(sphere.vertices.row(5).transpose()));
}

TEST(SphereMap, NamesWhatIsWrong) {
  const Mesh mesh = icosphereMesh(2);
  const ClosedSurface surface(mesh.vertices, mesh.faces, "phase 3");

  const MapError few = errorOf(surface, mesh.vertices.topRows(41));
  EXPECT_NE(std::string(few.what()).find("41 sphere positions for 42 vertices"), std::string::npos)
      << few.what();

  const MapError insideOut = errorOf(surface, -mesh.vertices);
  EXPECT_EQ(insideOut.count, 80);
  EXPECT_EQ(insideOut.first, 0);

  Points positions = mesh.vertices;
  positions.row(9) *= 1.1;
  const MapError offSphere = errorOf(surface, positions);
  EXPECT_EQ(offSphere.first, 9);
  EXPECT_NE(std::string(offSphere.what()).find("vertex 9"), std::string::npos) << offSphere.what();
}

}  // namespace
}  // namespace sphere_propagation::test
