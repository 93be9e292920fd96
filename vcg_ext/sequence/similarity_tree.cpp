// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/similarity_tree.h"

#include <string>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/registration/shape_alignment.h"

namespace sphere_propagation {
namespace {

double distanceBetween(const PreparedSurface& a, const PreparedSurface& b) {
  return shapeDistance(a, b, motionByAxes(a, b));
}

}  // namespace

Eigen::MatrixXd shapeDistances(const Sequence& sequence, ThreadPool& pool) {
  sequence.prepare(pool);
  const int count = sequence.size();
  Eigen::MatrixXd distances = Eigen::MatrixXd::Zero(count, count);
  pool.forEach(count, [&](int i) {
    for (int j = 0; j < i; ++j)
      distances(i, j) = distances(j, i) = distanceBetween(sequence[i], sequence[j]);
  });
  return distances;
}

PropagationTree minimumSpanningTree(const Eigen::MatrixXd& distances, int root) {
  const int layers = static_cast<int>(distances.rows());
  if (distances.cols() != layers || !distances.allFinite() || distances != distances.transpose())
    throw ArgumentError(
        "Distances between layers form a square, symmetric matrix of finite numbers; given is one "
        "of " +
        std::to_string(distances.rows()) + " by " + std::to_string(distances.cols()) + ".");
  PropagationTree tree = star(layers, root);  // which checks the root
  tree.order = {root};
  std::vector<char> reached(static_cast<size_t>(layers), 0);
  reached[root] = 1;
  while (static_cast<int>(tree.order.size()) < layers) {
    int next = -1;
    for (int i = 0; i < layers; ++i)
      if (!reached[i] &&
          (next < 0 || distances(i, tree.parent[i]) < distances(next, tree.parent[next])))
        next = i;
    reached[next] = 1;
    tree.order.push_back(next);
    for (int i = 0; i < layers; ++i) {
      if (reached[i]) continue;
      const double now = distances(i, tree.parent[i]), by = distances(i, next);
      if (by < now || (by == now && next < tree.parent[i])) tree.parent[i] = next;
    }
  }
  return tree;
}

SimilarityTree similarityTree(const Sequence& sequence, int root, ThreadPool& pool) {
  star(sequence.size(), root);  // checks the root before the work
  Eigen::MatrixXd distances = shapeDistances(sequence, pool);
  PropagationTree tree = minimumSpanningTree(distances, root);
  return {std::move(tree), std::move(distances)};
}

}  // namespace sphere_propagation
