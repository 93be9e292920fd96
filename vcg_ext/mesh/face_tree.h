// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A tree of bounding boxes over the faces of a mesh: what the locators search.

#include <array>
#include <cstddef>
#include <vector>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// Built once by splits into quarters, so its depth is logarithmic whatever the mesh is like. The
/// four boxes of a node are looked at together, which the processor does in a few instructions. The
/// corners are kept in the order of the leaves, so that a leaf's faces lie side by side in memory.
class FaceTree {
 public:
  struct Face {
    std::array<Vector3, 3> corner;
    int index = -1;  ///< in the mesh
  };
  /// One number for each of four boxes.
  using Four = Eigen::Array<double, 4, 1, Eigen::DontAlign>;
  /// Four boxes: their least and largest x, y, z.
  struct Boxes {
    std::array<Four, 3> low, high;
  };

  /// vertices: #V by 3, finite; faces: #F by 3, at least one; margin: by how much the boxes are
  /// larger than the faces in them, on every side (room for the rounding of a query).
  FaceTree(const Points& vertices, const Triangles& faces, double margin = 0);

  /// The same over faces in an order that is given, each face once: what is near in the order
  /// should be near in space. Several times quicker to build; how quick a search is depends on the
  /// order, what it finds does not.
  FaceTree(const Points& vertices, const Triangles& faces, const std::vector<int>& order);

  /// The faces in the tree's order.
  const std::vector<Face>& faces() const { return faces_; }

  /// Branch and bound. Visits every face but those in boxes whose bound exceeds the query's limit;
  /// nearer boxes first, so that a limit that shrinks while faces are visited soon excludes most.
  ///
  /// query.bounds(boxes)  for each box the least value that a face inside it can have
  /// query.limit()        boxes with a greater bound are skipped
  /// query.visit(i)       looks at faces()[i]
  template <class Query>
  void search(Query& query) const;

 private:
  struct Child {
    int first = 0;  // leaf: its first face; else its node
    int count = 0;  // leaf: its number of faces; else 0
  };
  struct Node {
    Boxes boxes;
    std::array<Child, 4> child;
    int children = 0;
  };

  template <class Split>
  void makeNodes(int count, const Split& split);
  void fitBoxes(double margin);

  std::vector<Node> nodes_;
  std::vector<Face> faces_;
};

template <class Query>
void FaceTree::search(Query& query) const {
  struct Entry {  // NOLINT(cppcoreguidelines-pro-type-member-init): 64 of them, written before they
                  // are read
    double bound;
    Child child;
  };
  std::array<Entry, 64> stack;  // at most three a level wait, and there are at most 16 levels
  size_t size = 0;
  Entry at{0, {0, 0}};
  for (;;) {
    if (at.bound <= query.limit()) {
      if (at.child.count == 0) {
        const Node& node = nodes_[static_cast<size_t>(at.child.first)];
        const Four bounds = query.bounds(node.boxes);
        const double limit = query.limit();
        const size_t before = size;
        for (int k = 0; k < node.children; ++k) {
          const Entry entry{bounds[k], node.child[static_cast<size_t>(k)]};
          if (!(entry.bound <= limit)) continue;
          size_t place = size++;  // the nearest last
          for (; place > before && stack[place - 1].bound < entry.bound; --place)
            stack[place] = stack[place - 1];
          stack[place] = entry;
        }
      } else {
        for (int i = at.child.first; i < at.child.first + at.child.count; ++i)
          query.visit(static_cast<size_t>(i));
      }
    }
    if (size == 0) return;
    at = stack[--size];
  }
}

}  // namespace sphere_propagation
