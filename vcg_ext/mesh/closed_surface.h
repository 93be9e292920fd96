// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A triangle mesh that is known to be a sphere topologically: the input of every algorithm here.

#include <memory>
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

/// Who lies beside whom on a closed triangle mesh.
///
/// Half-edges: half-edge h = 3 f + k runs from faces(f, k) to faces(f, (k + 1) % 3).
struct Connectivity {
  Triangles faces;          ///< #F by 3
  std::vector<int> twin;    ///< 3 #F: the half-edge along the same edge, the other way
  std::vector<int> offset;  ///< #V + 1: where the next two begin for each vertex
  std::vector<int> outgoing, neighbours;  ///< 3 #F each, counter-clockwise round each vertex

  int origin(int h) const { return faces(h / 3, h % 3); }
  int target(int h) const { return origin(next(h)); }
  static int next(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static int previous(int h) { return h % 3 == 0 ? h + 2 : h - 1; }
};

/// A closed, connected, manifold, outward oriented triangle surface of genus 0 with finite
/// coordinates and an area.
///
/// An object of this type passed every check, so what takes one need not check again. It also knows
/// its adjacency. Zero-area faces and vertices at the same place are allowed: they are no defect of
/// the topology.
///
/// Immutable, and cheap to copy: copies share what they hold.
class ClosedSurface {
 public:
  /// vertices: #V by 3, #V >= 4; faces: #F by 3; name: what errors call it. Throws SurfaceError,
  /// which says what is wrong, how often and where first.
  ClosedSurface(Points vertices, Triangles faces, std::string name = "surface");

  /// The same surface with its vertices elsewhere (#V by 3): moved, scaled, deformed. It shares the
  /// connectivity. Throws SurfaceError as the constructor does.
  ClosedSurface withVertices(Points vertices) const;

  const Points& vertices() const { return *vertices_; }
  const Triangles& faces() const { return connectivity_->faces; }
  const std::string& name() const { return *name_; }
  int vertexCount() const { return static_cast<int>(vertices().rows()); }
  int faceCount() const { return static_cast<int>(faces().rows()); }
  Vector3 vertex(int v) const { return vertices().row(v).transpose(); }

  /// The neighbours of vertex v, counter-clockwise seen from outside; faces (v, ring[i], ring[i +
  /// 1]).
  IndexRange ring(int v) const { return around(v, connectivity_->neighbours); }
  /// The half-edges from v to ring(v)[i], in the same order; h / 3 is the face (v, ring[i], ring[i
  /// + 1]).
  IndexRange outgoing(int v) const { return around(v, connectivity_->outgoing); }
  /// The half-edge that runs the other way along the same edge.
  int twin(int h) const { return connectivity_->twin[h]; }
  int origin(int h) const { return connectivity_->origin(h); }
  int target(int h) const { return connectivity_->target(h); }

  static int next(int h) { return Connectivity::next(h); }
  static int previous(int h) { return Connectivity::previous(h); }

  /// Whether both have the same faces in the same order: a map of one is a map of the other.
  bool hasFacesOf(const ClosedSurface& other) const;

 private:
  ClosedSurface(std::shared_ptr<const Connectivity> connectivity, Points vertices,
                std::shared_ptr<const std::string> name);
  IndexRange around(int v, const std::vector<int>& list) const {
    const std::vector<int>& offset = connectivity_->offset;
    return {list.data() + offset[v], list.data() + offset[v + 1]};
  }

  std::shared_ptr<const Connectivity> connectivity_;
  std::shared_ptr<const Points> vertices_;
  std::shared_ptr<const std::string> name_;
};

}  // namespace sphere_propagation
