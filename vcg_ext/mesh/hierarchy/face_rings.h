// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A closed mesh of genus 0 as the algorithms that move vertices over the sphere walk it: a face
/// list, and for each vertex the faces around it. (A ClosedSurface is one too, but not every level
/// of a hierarchy is a ClosedSurface.)

#include <vector>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/mesh/closed_surface.h"

namespace sphere_propagation {

struct FaceRings {
  Triangles faces;  ///< #F by 3
  std::vector<int>
      offset;  ///< #V + 1: corners of vertex v are corner[offset[v]] .. corner[offset[v + 1] - 1]
  /// 3 #F: corner 3 f + k is the k-th of face f. Counter-clockwise: the next corner's face lies
  /// across the edge from the vertex to the third vertex of this corner's face.
  std::vector<int> corner;

  int vertexCount() const { return static_cast<int>(offset.size()) - 1; }
  int faceCount() const { return static_cast<int>(faces.rows()); }
  int second(int c) const {
    return faces.data()[c % 3 == 2 ? c - 2 : c + 1];
  }  ///< the vertex after corner c
  int third(int c) const {
    return faces.data()[c % 3 == 0 ? c + 2 : c - 1];
  }  ///< the vertex before corner c

  static FaceRings of(const ClosedSurface& surface);
};

}  // namespace sphere_propagation
