// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A triangle mesh with any defect, on its way to a closed surface: what the steps of the
/// preparation hand on to each other.

#include <vector>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

struct BrokenMesh {
  Points vertices;          ///< #V by 3
  Triangles faces;          ///< #F by 3
  std::vector<int> source;  ///< #V: the vertex of the input that each was; -1: a new one
  std::vector<int> lid;  ///< #V: the number of the opening (from 1) whose lid it belongs to, or 0
  std::vector<int> faceLid;    ///< #F: the same of faces
  std::vector<char> turned;    ///< #F: whether it looks the other way than in the input
  std::vector<int> separated;  ///< #V: the first of the vertices that one vertex was split into

  BrokenMesh() = default;
  BrokenMesh(Points points, Triangles triangles);

  int vertexCount() const { return static_cast<int>(vertices.rows()); }
  int faceCount() const { return static_cast<int>(faces.rows()); }
  Vector3 vertex(int v) const { return vertices.row(v).transpose(); }

  /// Copies of vertices, the first of which gets the index that is returned.
  int addCopiesOf(const std::vector<int>& originals);
  /// New vertices, the same.
  int addVertices(const Points& points, int lidNumber);
  void addFaces(const Triangles& added, int lidNumber, char isTurned);

  /// Leaves out the faces that are not marked. keep: #F. Returns how many there were.
  int keepFaces(const std::vector<char>& keep);
  /// Leaves out the vertices that are not marked. keep: #V, true for all that faces use.
  int keepVertices(const std::vector<char>& keep);
  /// Leaves out the vertices that no face uses; of those that `spared` marks (by source) none.
  int dropUnusedVertices(const std::vector<char>& spared = {});
};

/// Twice the area of a face as a vector along its normal.
Vector3 areaVector(const Points& vertices, const Triangles& faces, int f);

/// Of all faces.
double areaOf(const BrokenMesh& mesh);

/// The half-edges of a mesh by the edges on which they lie. Half-edge h = 3 f + k runs from
/// faces(f, k) to faces(f, (k + 1) % 3).
class EdgeTable {
 public:
  /// faces: #F by 3, none uses a vertex twice.
  explicit EdgeTable(const Triangles& faces);

  int count() const { return static_cast<int>(start_.size()) - 1; }
  /// How many faces meet at an edge.
  int size(int edge) const { return start_[edge + 1] - start_[edge]; }
  /// Its i-th half-edge, in ascending order.
  int halfEdge(int edge, int i) const { return halfEdges_[start_[edge] + i]; }
  int edgeOf(int halfEdge) const { return edgeOf_[halfEdge]; }
  /// The other half-edge of an edge with two faces; -1: the edge has more or fewer.
  int twin(int halfEdge) const {
    const int edge = edgeOf_[halfEdge];
    if (size(edge) != 2) return -1;
    return this->halfEdge(edge, 0) == halfEdge ? this->halfEdge(edge, 1) : this->halfEdge(edge, 0);
  }

 private:
  std::vector<int> start_, halfEdges_, edgeOf_;
};

/// Sets that are united one by one; the representative of a set is its smallest member.
class DisjointSets {
 public:
  explicit DisjointSets(int count);
  int find(int i);
  bool unite(int i, int j);

 private:
  std::vector<int> parent_;
};

}  // namespace sphere_propagation
