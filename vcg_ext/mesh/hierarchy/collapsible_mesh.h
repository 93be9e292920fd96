// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A closed triangle mesh of genus 0 that can lose its vertices one after the other, and get them
/// back.
///
/// H. Hoppe, Progressive meshes, 1996. A half-edge collapse moves vertex u onto its neighbour v: u
/// and the two faces at the edge disappear. It keeps the mesh a sphere exactly when u and v have
/// two common neighbours (T. Dey, H. Edelsbrunner, S. Guha and D. Nekhayev, Topology preserving
/// edge contraction, 1999). As long as there are more than four vertices every vertex has such a
/// neighbour: the edges among the neighbours of u that do not belong to its ring can be drawn
/// outside the ring without crossing, so some neighbour has none.

#include <array>
#include <vector>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/mesh/hierarchy/face_rings.h"

namespace sphere_propagation {

class CollapsibleMesh {
 public:
  /// `surface` with its vertices in another order: vertex i here is order[i] there, a permutation.
  /// Points are in units of the extent, where squares of areas are numbers. A face stands for its
  /// area at first, or for minFaceShare of the mean where it is smaller. The numbering of `surface`
  /// is forgotten.
  CollapsibleMesh(const ClosedSurface& surface, const std::vector<int>& order);

  int vertexCount() const { return vertexCount_; }  ///< of those that are there
  int allVertices() const { return static_cast<int>(some_.size()); }
  bool isThere(int v) const { return degree_[v] > 0; }
  int degree(int v) const { return degree_[v]; }
  Vector3 point(int v) const { return points_.row(v).transpose(); }
  const Points& points() const { return points_; }
  float area(int h) const { return area_[h / 3]; }  ///< of the face of half-edge h

  // Half-edge h = 3 f + k runs from corner k of face f to the next one.
  int origin(int h) const { return origin_[h]; }
  int target(int h) const { return origin_[next(h)]; }
  int twin(int h) const { return twin_[h]; }
  int someHalfEdge(int v) const { return some_[v]; }  ///< one that leaves v
  int turned(int h) const {
    return twin_[previous(h)];
  }  ///< the next one round its origin, counter-clockwise
  static int next(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static int previous(int h) { return h % 3 == 0 ? h + 2 : h - 1; }

  /// Whether the origin of h can be moved onto its target.
  bool canCollapse(int h) const;

  /// Moves u, the origin of h, onto its target. The area that the faces around u stood for is
  /// shared out among those that take their place, by their own areas (and evenly to a tenth, so
  /// that none goes empty).
  void collapse(int h);

  /// Takes back the last collapse, areas included; returns the vertex that is there again.
  int undo();

  /// The half-edge of the collapse that undo() would take back.
  int lastCollapse() const { return collapses_.back(); }

  /// The four vertices that are left: the second to the fourth run counter-clockwise round the
  /// first.
  std::array<int, 4> tetrahedron() const;

  /// What is there now, its vertices renumbered in their order (`vertices`: their numbers here) and
  /// the faces ordered by their first vertex; `faceOf`: the number here of each face.
  FaceRings rings(std::vector<int>& vertices, std::vector<int>& faceOf) const;

 private:
  double flatArea(int f) const;
  bool areNeighbours(int a, int b) const;

  Points points_;
  std::vector<int> origin_, twin_, some_, degree_;  // degree 0: not there
  std::vector<float> area_;
  std::vector<int> collapses_;
  std::vector<float>
      formerAreas_;  // of each collapse: the faces around u, from h counter-clockwise
  int vertexCount_ = 0;
};

}  // namespace sphere_propagation
