#include "vcg_ext/mesh/face_tree.h"

#include <algorithm>

namespace sphere_propagation {
namespace {

constexpr int leafSize = 4;  // measured: 2 to 8 are within a few percent

Vector3 centroid(const FaceTree::Face& face) { return face.corner[0] / 3 + face.corner[1] / 3 + face.corner[2] / 3; }

}  // namespace

FaceTree::FaceTree(const Points& vertices, const Triangles& faces, double margin) {
  std::vector<Face> unordered(static_cast<size_t>(faces.rows()));
  struct Item {  // what is sorted: small, as it is moved about at every level
    Vector3 centre;
    int face = -1;
  };
  std::vector<Item> items(unordered.size());
  for (size_t f = 0; f < items.size(); ++f) {
    Face& face = unordered[f];
    face.index = static_cast<int>(f);
    for (size_t k = 0; k < 3; ++k)
      face.corner[k] = vertices.row(faces(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(k))).transpose();
    items[f] = {centroid(face), face.index};
  }

  // Depth first, left before right, so that the left child of a node is the next one.
  struct Task {
    int begin, end, parent;  // parent: the node whose right child this is, or -1
  };
  std::vector<Task> tasks{{0, static_cast<int>(items.size()), -1}};
  nodes_.reserve(items.size());
  while (!tasks.empty()) {
    const Task task = tasks.back();
    tasks.pop_back();
    const int here = static_cast<int>(nodes_.size());
    if (task.parent >= 0) nodes_[static_cast<size_t>(task.parent)].first = here;
    const auto begin = items.begin() + task.begin, end = items.begin() + task.end;
    Node node{Vector3::Zero(), Vector3::Zero(), task.begin, task.end - task.begin};
    if (node.count > leafSize) {
      Vector3 low = begin->centre, high = begin->centre;
      for (auto item = begin; item != end; ++item) {
        low = low.cwiseMin(item->centre);
        high = high.cwiseMax(item->centre);
      }
      Eigen::Index axis = 0;
      (high - low).maxCoeff(&axis);
      const int middle = task.begin + node.count / 2;
      std::nth_element(begin, items.begin() + middle, end, [axis](const Item& a, const Item& b) {
        // Equal centroids fall back on the index: the tree is the same with every standard library.
        return a.centre[axis] < b.centre[axis] || (a.centre[axis] == b.centre[axis] && a.face < b.face);
      });
      node.count = 0;
      tasks.push_back({middle, task.end, here});
      tasks.push_back({task.begin, middle, -1});
    } else {
      std::sort(begin, end, [](const Item& a, const Item& b) { return a.face < b.face; });
    }
    nodes_.push_back(node);
  }
  faces_.reserve(items.size());
  for (const Item& item : items) faces_.push_back(unordered[static_cast<size_t>(item.face)]);
  fitBoxes(margin);
}

void FaceTree::fitBoxes(double margin) {
  for (size_t i = nodes_.size(); i-- > 0;) {  // children come behind their parents
    Node& node = nodes_[i];
    if (node.count == 0) {
      const Node &left = nodes_[i + 1], &right = nodes_[static_cast<size_t>(node.first)];
      node.low = left.low.cwiseMin(right.low);
      node.high = left.high.cwiseMax(right.high);
      continue;
    }
    node.low = node.high = faces_[static_cast<size_t>(node.first)].corner[0];
    for (int f = node.first; f < node.first + node.count; ++f)
      for (const Vector3& corner : faces_[static_cast<size_t>(f)].corner) {
        node.low = node.low.cwiseMin(corner);
        node.high = node.high.cwiseMax(corner);
      }
    node.low.array() -= margin;
    node.high.array() += margin;
  }
}

}  // namespace sphere_propagation
