// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/face_tree.h"

#include <algorithm>

namespace sphere_propagation {
namespace {

constexpr int leafSize = 1;  // measured: 2 and 4 look at more faces than they save boxes

Vector3 centroid(const FaceTree::Face& face) {
  return face.corner[0] / 3 + face.corner[1] / 3 + face.corner[2] / 3;
}

FaceTree::Face faceOf(const Points& vertices, const Triangles& faces, int f) {
  FaceTree::Face face;
  face.index = f;
  for (size_t k = 0; k < 3; ++k)
    face.corner[k] = vertices.row(faces(f, static_cast<Eigen::Index>(k))).transpose();
  return face;
}

}  // namespace

/// split(begin, middle, end) brings the faces of a range into an order in which its halves belong
/// together.
template <class Split>
void FaceTree::makeNodes(int count, const Split& split) {
  struct Range {
    int begin, end;
    int size() const { return end - begin; }
  };
  struct Task {
    Range range;
    int parent, place;  // which child of which node this becomes; parent -1: the root
  };
  std::vector<Task> tasks{{{0, count}, -1, 0}};
  nodes_.reserve(static_cast<size_t>(count) / 3 * 2 + 1);
  while (!tasks.empty()) {
    const Task task = tasks.back();
    tasks.pop_back();
    const int here = static_cast<int>(nodes_.size());
    if (task.parent >= 0)
      nodes_[static_cast<size_t>(task.parent)].child[static_cast<size_t>(task.place)] = {here, 0};
    std::vector<Range> parts{task.range};
    while (parts.size() < 4) {
      const auto largest =
          std::max_element(parts.begin(), parts.end(),
                           [](const Range& a, const Range& b) { return a.size() < b.size(); });
      if (largest->size() <= leafSize) break;
      const Range whole = *largest;
      const int middle = whole.begin + whole.size() / 2;
      split(whole.begin, middle, whole.end);
      *largest = {whole.begin, middle};
      parts.insert(largest + 1, {middle, whole.end});
    }
    Node node;
    node.children = static_cast<int>(parts.size());
    for (size_t k = parts.size(); k-- > 0;)
      if (parts[k].size() <= leafSize)
        node.child[k] = {parts[k].begin, parts[k].size()};
      else
        tasks.push_back({parts[k], here, static_cast<int>(k)});
    nodes_.push_back(node);
  }
}

FaceTree::FaceTree(const Points& vertices, const Triangles& faces, double margin) {
  std::vector<Face> unordered(static_cast<size_t>(faces.rows()));
  struct Item {  // what is sorted: small, as it is moved about at every level
    Vector3 centre;
    int face = -1;
  };
  std::vector<Item> items(unordered.size());
  for (size_t f = 0; f < items.size(); ++f) {
    unordered[f] = faceOf(vertices, faces, static_cast<int>(f));
    items[f] = {centroid(unordered[f]), static_cast<int>(f)};
  }
  makeNodes(static_cast<int>(items.size()), [&items](int first, int middle, int last) {
    const auto begin = items.begin() + first, end = items.begin() + last;
    Vector3 low = begin->centre, high = begin->centre;
    for (auto item = begin; item != end; ++item) {
      low = low.cwiseMin(item->centre);
      high = high.cwiseMax(item->centre);
    }
    Eigen::Index axis = 0;
    (high - low).maxCoeff(&axis);
    std::nth_element(begin, items.begin() + middle, end, [axis](const Item& a, const Item& b) {
      // Equal centroids fall back on the index: the tree is the same with every standard library.
      return a.centre[axis] < b.centre[axis] ||
             (a.centre[axis] == b.centre[axis] && a.face < b.face);
    });
  });
  faces_.reserve(items.size());
  for (const Item& item : items) faces_.push_back(unordered[static_cast<size_t>(item.face)]);
  fitBoxes(margin);
}

FaceTree::FaceTree(const Points& vertices, const Triangles& faces, const std::vector<int>& order) {
  makeNodes(static_cast<int>(order.size()), [](int, int, int) {});
  faces_.reserve(order.size());
  for (const int f : order) faces_.push_back(faceOf(vertices, faces, f));
  fitBoxes(0);
}

void FaceTree::fitBoxes(double margin) {
  const auto set = [](Boxes& boxes, int k, const Vector3& low, const Vector3& high) {
    for (int axis = 0; axis < 3; ++axis) {
      boxes.low[static_cast<size_t>(axis)][k] = low[axis];
      boxes.high[static_cast<size_t>(axis)][k] = high[axis];
    }
  };
  for (size_t i = nodes_.size(); i-- > 0;) {  // children come behind their parents
    Node& node = nodes_[i];
    for (int k = 0; k < 4; ++k) {
      const Child& child = node.child[static_cast<size_t>(k)];
      Vector3 low = Vector3::Zero(), high = Vector3::Zero();
      if (k < node.children && child.count > 0) {
        low = high = faces_[static_cast<size_t>(child.first)].corner[0];
        for (int f = child.first; f < child.first + child.count; ++f)
          for (const Vector3& corner : faces_[static_cast<size_t>(f)].corner) {
            low = low.cwiseMin(corner);
            high = high.cwiseMax(corner);
          }
        low.array() -= margin;
        high.array() += margin;
      } else if (k < node.children) {
        const Node& below = nodes_[static_cast<size_t>(child.first)];
        for (int axis = 0; axis < 3; ++axis) {
          low[axis] = below.boxes.low[static_cast<size_t>(axis)].head(below.children).minCoeff();
          high[axis] = below.boxes.high[static_cast<size_t>(axis)].head(below.children).maxCoeff();
        }
      }
      set(node.boxes, k, low, high);
    }
  }
}

}  // namespace sphere_propagation
