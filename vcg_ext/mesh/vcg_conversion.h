// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// From and to VCG meshes: the only place where vcg_ext meets them. Any MeshType will do, float or
/// double, whose faces are triangles with vertex references.

#include <vcg/complex/complex.h>

#include <Eigen/LU>
#include <string>
#include <utility>
#include <vector>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/mesh/closed_surface.h"

namespace sphere_propagation {

/// A surface, and where its vertices are in the mesh that it was made from.
struct MeshSurface {
  ClosedSurface surface;
  std::vector<int> meshVertex;  ///< #V: index into mesh.vert of each vertex of the surface
};

/// A mesh's matrix for surfaceFromMesh.
template <class Scalar>
Eigen::Matrix4d matrixFromVcg(const vcg::Matrix44<Scalar>& matrix) {
  Eigen::Matrix4d result;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      result(row, column) = static_cast<double>(matrix.ElementAt(row, column));
  return result;
}

/// What a mesh holds, whether it is a surface or not, and where its vertices are in it.
struct MeshContent {
  Points vertices;
  Triangles faces;
  std::vector<int> meshVertex;  ///< #V: index into mesh.vert of each vertex
};

/// Deleted elements left out, the matrix applied.
///
/// transform: an affine matrix, which maps mesh.vert[i].P() to where the mesh is seen (its last
/// row is taken as 0 0 0 1). One that mirrors (negative determinant) would turn the surface inside
/// out: its faces are then reversed (corners 1 and 2 exchanged), so that what was outward stays
/// outward.
template <class MeshType>
MeshContent contentOfMesh(const MeshType& mesh,
                          const Eigen::Matrix4d& transform = Eigen::Matrix4d::Identity()) {
  const Eigen::Matrix3d linear = transform.topLeftCorner<3, 3>();
  const Vector3 translation = transform.topRightCorner<3, 1>();
  std::vector<int> compacted(mesh.vert.size(), -1), meshVertex;
  meshVertex.reserve(mesh.vert.size());
  Points vertices(static_cast<Eigen::Index>(mesh.vert.size()), 3);
  for (size_t i = 0; i < mesh.vert.size(); ++i) {
    if (mesh.vert[i].IsD()) continue;
    const auto& p = mesh.vert[i].cP();
    const Vector3 point(static_cast<double>(p[0]), static_cast<double>(p[1]),
                        static_cast<double>(p[2]));
    compacted[i] = static_cast<int>(meshVertex.size());
    vertices.row(compacted[i]) = (linear * point + translation).transpose();
    meshVertex.push_back(static_cast<int>(i));
  }
  vertices.conservativeResize(static_cast<Eigen::Index>(meshVertex.size()), 3);

  const bool mirrored = linear.determinant() < 0;
  Triangles faces(static_cast<Eigen::Index>(mesh.face.size()), 3);
  Eigen::Index count = 0;
  for (size_t i = 0; i < mesh.face.size(); ++i) {
    if (mesh.face[i].IsD()) continue;
    for (int k = 0; k < 3; ++k)
      faces(count, k) = compacted[static_cast<size_t>(mesh.face[i].cV(k) - &mesh.vert[0])];
    if (mirrored) std::swap(faces(count, 1), faces(count, 2));
    ++count;
  }
  faces.conservativeResize(count, 3);
  return {std::move(vertices), std::move(faces), std::move(meshVertex)};
}

/// The closed surface that a mesh stands for; transform as above. name: what errors call the
/// surface (the mesh's label). Throws SurfaceError as ClosedSurface does. Indices in its text
/// count the elements that are not deleted.
template <class MeshType>
MeshSurface surfaceFromMesh(const MeshType& mesh,
                            const Eigen::Matrix4d& transform = Eigen::Matrix4d::Identity(),
                            const std::string& name = "surface") {
  MeshContent content = contentOfMesh(mesh, transform);
  return {ClosedSurface(std::move(content.vertices), std::move(content.faces), name),
          std::move(content.meshVertex)};
}

/// Makes `mesh` consist of these points and faces and nothing else, and updates its bounding box.
/// Normals and whatever else the mesh carries are the caller's.
///
/// points: #V by 3; faces: #F by 3, may be empty.
template <class MeshType>
void meshFromSurface(const Points& points, const Triangles& faces, MeshType& mesh) {
  using Scalar = typename MeshType::ScalarType;
  mesh.Clear();
  vcg::tri::Allocator<MeshType>::AddVertices(mesh, static_cast<size_t>(points.rows()));
  vcg::tri::Allocator<MeshType>::AddFaces(mesh, static_cast<size_t>(faces.rows()));
  for (Eigen::Index v = 0; v < points.rows(); ++v)
    mesh.vert[static_cast<size_t>(v)].P() = typename MeshType::CoordType(
        static_cast<Scalar>(points(v, 0)), static_cast<Scalar>(points(v, 1)),
        static_cast<Scalar>(points(v, 2)));
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      mesh.face[static_cast<size_t>(f)].V(k) = &mesh.vert[static_cast<size_t>(faces(f, k))];
  vcg::tri::UpdateBounding<MeshType>::Box(mesh);
}

}  // namespace sphere_propagation
