// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/vcg_conversion.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <type_traits>

#include "tests/core/test_meshes.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation::test {
namespace {

class FloatVertex;
class FloatFace;
struct FloatTypes
    : vcg::UsedTypes<vcg::Use<FloatVertex>::AsVertexType, vcg::Use<FloatFace>::AsFaceType> {};
class FloatVertex : public vcg::Vertex<FloatTypes, vcg::vertex::Coord3f, vcg::vertex::BitFlags> {};
class FloatFace : public vcg::Face<FloatTypes, vcg::face::VertexRef, vcg::face::BitFlags> {};
class FloatMesh : public vcg::tri::TriMesh<std::vector<FloatVertex>, std::vector<FloatFace>> {};

class DoubleVertex;
class DoubleFace;
struct DoubleTypes
    : vcg::UsedTypes<vcg::Use<DoubleVertex>::AsVertexType, vcg::Use<DoubleFace>::AsFaceType> {};
class DoubleVertex : public vcg::Vertex<DoubleTypes, vcg::vertex::Coord3d, vcg::vertex::BitFlags> {
};
class DoubleFace : public vcg::Face<DoubleTypes, vcg::face::VertexRef, vcg::face::BitFlags> {};
class DoubleMesh : public vcg::tri::TriMesh<std::vector<DoubleVertex>, std::vector<DoubleFace>> {};

template <class MeshType>
class VcgConversion : public ::testing::Test {};
using MeshTypes = ::testing::Types<FloatMesh, DoubleMesh>;
TYPED_TEST_SUITE(VcgConversion, MeshTypes);

TYPED_TEST(VcgConversion, ThereAndBack) {
  const Mesh mesh = noisyEllipsoid(1);
  TypeParam vcgMesh;
  meshFromSurface(mesh.vertices, mesh.faces, vcgMesh);
  EXPECT_EQ(vcgMesh.VN(), mesh.vertices.rows());
  EXPECT_EQ(vcgMesh.FN(), mesh.faces.rows());
  EXPECT_NEAR(static_cast<double>(vcgMesh.bbox.max[0]), mesh.vertices.col(0).maxCoeff(), 1e-5);
  const MeshSurface back = surfaceFromMesh(vcgMesh);
  EXPECT_EQ(back.surface.faces(), mesh.faces);
  EXPECT_EQ(back.surface.name(), "surface");
  if (std::is_same_v<typename TypeParam::ScalarType, double>)
    EXPECT_EQ(back.surface.vertices(), mesh.vertices);
  else
    EXPECT_EQ(back.surface.vertices(),
              mesh.vertices.template cast<float>().template cast<double>());
  for (int v = 0; v < back.surface.vertexCount(); ++v)
    EXPECT_EQ(back.meshVertex[static_cast<size_t>(v)], v);
  // Again, into the same mesh: what was there is gone.
  const Mesh small = octahedron();
  meshFromSurface(small.vertices, small.faces, vcgMesh);
  EXPECT_EQ(vcgMesh.VN(), 6);
  EXPECT_EQ(vcgMesh.bbox.max[0], 1);
  EXPECT_EQ(surfaceFromMesh(vcgMesh).surface.vertices(), small.vertices);
}

TYPED_TEST(VcgConversion, DeletedElementsAreLeftOut) {
  // The second of two octahedra is what is left.
  const Mesh mesh = twoSpheres();
  TypeParam vcgMesh;
  meshFromSurface(mesh.vertices, mesh.faces, vcgMesh);
  EXPECT_THROW(surfaceFromMesh(vcgMesh), SurfaceError);
  using Allocator = vcg::tri::Allocator<TypeParam>;
  for (size_t f = 0; f < 8; ++f) Allocator::DeleteFace(vcgMesh, vcgMesh.face[f]);
  for (size_t v = 0; v < 6; ++v) Allocator::DeleteVertex(vcgMesh, vcgMesh.vert[v]);
  const MeshSurface left = surfaceFromMesh(vcgMesh);
  EXPECT_EQ(left.surface.vertices(), mesh.vertices.bottomRows(6));
  EXPECT_EQ(left.surface.faces(), octahedron().faces);
  EXPECT_EQ(left.meshVertex, (std::vector<int>{6, 7, 8, 9, 10, 11}));
}

TYPED_TEST(VcgConversion, AFaceOfADeletedVertexIsAnError) {
  const Mesh mesh = icosahedron();
  TypeParam vcgMesh;
  meshFromSurface(mesh.vertices, mesh.faces, vcgMesh);
  vcg::tri::Allocator<TypeParam>::DeleteVertex(vcgMesh, vcgMesh.vert[3]);
  try {
    surfaceFromMesh(vcgMesh, Eigen::Matrix4d::Identity(), "broken");
    FAIL();
  } catch (const SurfaceError& error) {
    EXPECT_EQ(error.fault(), Fault::IndexOutOfRange);
    EXPECT_EQ(error.finding().count, 5);
    EXPECT_EQ(error.finding().name, "broken");
  }
}

TYPED_TEST(VcgConversion, AppliesTheMatrix) {
  const Mesh mesh = octahedron();
  TypeParam vcgMesh;
  meshFromSurface(mesh.vertices, mesh.faces, vcgMesh);
  Eigen::Matrix4d transform = Eigen::Matrix4d::Identity();
  transform.topLeftCorner<3, 3>() = 2 * randomRotation(4);
  transform.topRightCorner<3, 1>() << 10, 20, 30;
  const ClosedSurface surface = surfaceFromMesh(vcgMesh, transform).surface;
  const Mesh expected = transformed(mesh, randomRotation(4), 2, {10, 20, 30});
  EXPECT_LT((surface.vertices() - expected.vertices).norm(), 1e-14);
  EXPECT_EQ(surface.faces(), mesh.faces);
}

TYPED_TEST(VcgConversion, AMirrorKeepsTheSurfaceOutward) {
  const Mesh mesh = ellipsoid(3, 2, 1, 3);
  TypeParam vcgMesh;
  meshFromSurface(mesh.vertices, mesh.faces, vcgMesh);
  for (const Eigen::Vector3d& scale :
       {Eigen::Vector3d(-1, 1, 1), Eigen::Vector3d(1, 1, -2), Eigen::Vector3d(-1, -1, -1)}) {
    Eigen::Matrix4d transform = Eigen::Matrix4d::Identity();
    transform.diagonal().head<3>() = scale;
    const ClosedSurface surface = surfaceFromMesh(vcgMesh, transform).surface;
    EXPECT_NEAR(enclosedVolume(surface.vertices(), surface.faces()),
                std::fabs(scale.prod()) * enclosedVolume(mesh.vertices, mesh.faces), 1e-5);
    for (int v = 0; v < surface.vertexCount(); ++v)  // vertices stay where they are in the list
      EXPECT_LT((surface.vertex(v) - scale.cwiseProduct(mesh.vertices.row(v).transpose())).norm(),
                1e-6);
  }
}

TYPED_TEST(VcgConversion, EmptyAndPointsOnly) {
  TypeParam vcgMesh;
  EXPECT_THROW(surfaceFromMesh(vcgMesh), SurfaceError);
  meshFromSurface(octahedron().vertices, Triangles(0, 3), vcgMesh);
  EXPECT_EQ(vcgMesh.VN(), 6);
  EXPECT_EQ(vcgMesh.FN(), 0);
  EXPECT_THROW(surfaceFromMesh(vcgMesh), SurfaceError);
}

TEST(MatrixFromVcg, KeepsRowsAndColumns) {
  vcg::Matrix44f matrix;
  matrix.SetIdentity();
  matrix.ElementAt(0, 3) = 5;
  matrix.ElementAt(2, 1) = -7;
  Eigen::Matrix4d expected = Eigen::Matrix4d::Identity();
  expected(0, 3) = 5;
  expected(2, 1) = -7;
  EXPECT_EQ(matrixFromVcg(matrix), expected);
}

}  // namespace
}  // namespace sphere_propagation::test
