#pragma once
/// A tree of bounding boxes over the faces of a mesh: what the locators search.

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// Built once by median splits, so its depth is logarithmic whatever the mesh is like. The corners are kept in the
/// order of the leaves, so that a leaf's faces lie side by side in memory.
class FaceTree {
 public:
  struct Face {
    std::array<Vector3, 3> corner;
    int index = -1;  ///< in the mesh
  };

  /// vertices: #V by 3, finite; faces: #F by 3, at least one; margin: by how much the boxes are larger than the faces
  /// in them, on every side (room for the rounding of a query).
  FaceTree(const Points& vertices, const Triangles& faces, double margin = 0);

  /// The faces in the tree's order.
  const std::vector<Face>& faces() const { return faces_; }

  /// Branch and bound. Visits every face but those in boxes whose bound exceeds the query's limit; nearer boxes first,
  /// so that a limit that shrinks while faces are visited soon excludes most.
  ///
  /// query.bound(low, high)  the least value that a face inside that box can have
  /// query.limit()           boxes with a greater bound are skipped
  /// query.visit(i)          looks at faces()[i]
  template <class Query>
  void search(Query& query) const;

 private:
  struct Node {
    Vector3 low, high;
    int first;  // leaf: its first face; else the right child, the left one being the next node
    int count;  // leaf: its number of faces; else 0
  };

  void fitBoxes(double margin);

  std::vector<Node> nodes_;
  std::vector<Face> faces_;
};

template <class Query>
void FaceTree::search(Query& query) const {
  struct Entry {
    double bound;
    int node;
  };
  std::array<Entry, 64> stack;  // one entry per level, and there are at most 31
  size_t size = 0;
  Entry at{query.bound(nodes_[0].low, nodes_[0].high), 0};
  for (;;) {
    if (at.bound <= query.limit()) {
      const Node& node = nodes_[static_cast<size_t>(at.node)];
      if (node.count == 0) {
        const Node &left = nodes_[static_cast<size_t>(at.node) + 1], &right = nodes_[static_cast<size_t>(node.first)];
        Entry near{query.bound(left.low, left.high), at.node + 1}, far{query.bound(right.low, right.high), node.first};
        if (far.bound < near.bound) std::swap(near, far);
        stack[size++] = far;
        at = near;
        continue;
      }
      for (int i = node.first; i < node.first + node.count; ++i) query.visit(static_cast<size_t>(i));
    }
    if (size == 0) return;
    at = stack[--size];
  }
}

}  // namespace sphere_propagation
