// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Closest points on a triangle mesh.

#include <vector>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/mesh/face_tree.h"

namespace sphere_propagation {

/// A point of a triangle mesh.
struct SurfacePoint {
  int face = -1;  ///< -1: none was found
  Vector3 weights =
      Vector3::Zero();  ///< barycentric, of the face's corners in order; none negative, sum 1
  double distance = 0;  ///< from the query

  /// The value of a per-vertex quantity (#V by 3) at this point.
  Vector3 interpolate(const Triangles& faces, const Points& values) const {
    return weights[0] * values.row(faces(face, 0)).transpose() +
           weights[1] * values.row(faces(face, 1)).transpose() +
           weights[2] * values.row(faces(face, 2)).transpose();
  }
};

/// A tree of bounding boxes over the faces of a mesh; built once, asked often. Copies what it needs
/// of the mesh.
class SurfaceLocator {
 public:
  /// vertices: #V by 3, finite; faces: #F by 3, at least one; zero-area faces are fine.
  SurfaceLocator(const Points& vertices, const Triangles& faces);

  /// The same over faces in an order that is given, as in FaceTree: quicker to build, with the same
  /// answers.
  SurfaceLocator(const Points& vertices, const Triangles& faces, const std::vector<int>& order);

  /// The faces in the tree's order, in which what is near is near in space.
  std::vector<int> order() const;

  /// The point of the mesh closest to x. Of faces at the same (computed) distance the one with the
  /// smallest index. near: a face that is probably close, to look at first; -1: none. It saves time
  /// and changes nothing.
  SurfacePoint closest(const Vector3& x, int near = -1) const;

  /// The same among the faces whose unit normal has a dot product >= minCosine with the unit vector
  /// `direction`; face = -1 when there is none. Faces without area agree with no direction.
  SurfacePoint closest(const Vector3& x, const Vector3& direction, double minCosine,
                       int near = -1) const;

 private:
  void orderFaces();

  FaceTree tree_;
  std::vector<size_t> places_;    // of the mesh's faces in the tree's order
  std::vector<Vector3> normals_;  // unit normals in the tree's order; zero for faces without area
};

}  // namespace sphere_propagation
