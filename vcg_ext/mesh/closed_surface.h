// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A triangle mesh that is known to be a sphere topologically: the input of every algorithm here.

#include <string>
#include <vector>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// A run of consecutive indices, for range-based loops.
class IndexRange {
 public:
  IndexRange(const int* begin, const int* end) : begin_(begin), end_(end) {}
  const int* begin() const { return begin_; }
  const int* end() const { return end_; }
  int size() const { return static_cast<int>(end_ - begin_); }
  int operator[](int i) const { return begin_[i]; }

 private:
  const int* begin_;
  const int* end_;
};

/// A closed, connected, manifold, outward oriented triangle surface of genus 0 with finite
/// coordinates and an area.
///
/// An object of this type passed every check, so what takes one need not check again. It also knows
/// its adjacency. Zero-area faces and vertices at the same place are allowed: they are no defect of
/// the topology.
///
/// Half-edges: half-edge h = 3 f + k runs from faces()(f, k) to faces()(f, (k + 1) % 3).
class ClosedSurface {
 public:
  /// vertices: #V by 3, #V >= 4; faces: #F by 3; name: what errors call it (a layer's label).
  /// Throws SurfaceError, which says what is wrong, how often, where first, and which MeshLab
  /// filter mends it.
  ClosedSurface(Points vertices, Triangles faces, std::string name = "surface");

  const Points& vertices() const { return vertices_; }
  const Triangles& faces() const { return faces_; }
  const std::string& name() const { return name_; }
  int vertexCount() const { return static_cast<int>(vertices_.rows()); }
  int faceCount() const { return static_cast<int>(faces_.rows()); }
  Vector3 vertex(int v) const { return vertices_.row(v).transpose(); }

  /// The neighbours of vertex v, counter-clockwise seen from outside; faces (v, ring[i], ring[i +
  /// 1]).
  IndexRange ring(int v) const {
    return {ring_.data() + offset_[v], ring_.data() + offset_[v + 1]};
  }
  /// The half-edges from v to ring(v)[i], in the same order; h / 3 is the face (v, ring[i], ring[i
  /// + 1]).
  IndexRange outgoing(int v) const {
    return {outgoing_.data() + offset_[v], outgoing_.data() + offset_[v + 1]};
  }
  /// The half-edge that runs the other way along the same edge.
  int twin(int h) const { return twin_[h]; }
  int origin(int h) const { return faces_(h / 3, h % 3); }
  int target(int h) const { return origin(next(h)); }

  static int next(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static int previous(int h) { return h % 3 == 0 ? h + 2 : h - 1; }

 private:
  void checkElements() const;
  void connectEdges();
  void connectVertices();
  void checkTopology() const;
  void checkGeometry() const;

  Points vertices_;
  Triangles faces_;
  std::string name_;
  std::vector<int> twin_;                      // 3 #F
  std::vector<int> offset_, outgoing_, ring_;  // #V + 1, 3 #F, 3 #F
};

}  // namespace sphere_propagation
