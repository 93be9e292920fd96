// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The surface that a model is fitted to: closed or open, whole or a part, with noise and holes.

#include <string>
#include <vector>

#include "vcg_ext/mesh/surface_locator.h"

namespace sphere_propagation {

class FittingTarget {
 public:
  /// vertices: #V by 3, those of faces finite; faces: #F by 3, outside counter-clockwise; what is
  /// in no face is left aside. name: what errors call it. Throws SurfaceError where there is no
  /// face, no area, an index or coordinate that cannot be, or where it is closed and inside out.
  FittingTarget(const Points& vertices, const Triangles& faces,
                const std::string& name = "surface");

  /// In the plane through its centre across x.
  FittingTarget mirrored() const;

  /// No face has an edge to itself.
  bool closed() const { return closed_; }
  double area() const { return area_; }
  double meanEdge() const { return meanEdge_; }
  const Vector3& centre() const { return centre_; }  ///< by area

  /// Points spread evenly over the area, none of them at an edge of the surface, and the normals
  /// around them, averaged over two rings, as noise spoils normals first.
  const Points& samples() const { return samples_; }
  const Points& sampleNormals() const { return sampleNormals_; }

  /// The closest point among the faces that look this way (agreement, below); face -1: none does,
  /// or it lies at the edge of an open surface, beyond which nobody knows what is there.
  /// near: a face that is probably close, to look at first, or -1; becomes the one that is closest.
  SurfacePoint closest(const Vector3& x, const Vector3& normal, int& near) const;
  Vector3 pointAt(const SurfacePoint& point) const { return point.interpolate(faces_, vertices_); }

  static constexpr int sampleCount = 500;
  /// Least dot product of normals that agree.
  static constexpr double agreement = 0.4;

 private:
  struct UsedMesh {  // without the vertices that are in no face
    Points vertices;
    Triangles faces;
  };
  static UsedMesh usedPartOf(const Points& vertices, const Triangles& faces,
                             const std::string& name);
  FittingTarget(UsedMesh used, const std::string& name);
  void sample(const Eigen::VectorXd& areas);

  Points vertices_;
  Triangles faces_;
  SurfaceLocator locator_;
  std::vector<char> atEdge_;  // of each face
  bool closed_ = true;
  double area_ = 0, meanEdge_ = 0;
  Vector3 centre_ = Vector3::Zero();
  Points samples_, sampleNormals_;
};

/// Faces with a corner on an edge that has no other face. faces: #F by 3.
std::vector<char> facesAtEdge(const Triangles& faces);

}  // namespace sphere_propagation
