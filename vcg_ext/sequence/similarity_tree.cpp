// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/similarity_tree.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/registration/shape_alignment.h"

namespace sphere_propagation {
namespace {

constexpr double unknown = std::numeric_limits<double>::infinity();
using Pair = std::pair<int, int>;  // the larger number first

double distanceBetween(const PreparedSurface& a, const PreparedSurface& b) {
  return shapeDistance(a, b, motionByAxes(a, b));
}

void compare(const Sequence& sequence, const std::vector<Pair>& pairs, ThreadPool& pool,
             Eigen::MatrixXd& distances) {
  pool.forEach(static_cast<int>(pairs.size()), [&](int k) {
    const auto [i, j] = pairs[static_cast<size_t>(k)];
    distances(i, j) = distances(j, i) = distanceBetween(sequence[i], sequence[j]);
  });
}

std::vector<int> evenlySpread(int count, int most) {
  const int chosen = std::clamp(most, 1, count);
  std::vector<int> numbers;
  for (int k = 0; k < chosen; ++k)
    numbers.push_back(static_cast<int>(static_cast<long>(k) * count / chosen));
  return numbers;
}

std::vector<Pair> pairsWith(const std::vector<int>& sample, int count) {
  std::vector<char> isSample(static_cast<size_t>(count), 0);
  for (const int s : sample) isSample[static_cast<size_t>(s)] = 1;
  std::vector<Pair> pairs;
  for (int i = 0; i < count; ++i)
    for (const int s : sample)
      if (s < i || isSample[static_cast<size_t>(i)] == 0) {
        if (s != i) pairs.emplace_back(std::max(i, s), std::min(i, s));
      }
  return pairs;
}

/// Pairs that were not compared yet, of each surface and those with the most alike distances from
/// the sample.
std::vector<Pair> likelyNeighbours(const Eigen::MatrixXd& distances, const std::vector<int>& sample,
                                   int neighbours, ThreadPool& pool) {
  const auto count = static_cast<int>(distances.rows());
  Eigen::MatrixXd signatures(static_cast<Eigen::Index>(sample.size()), count);
  for (size_t s = 0; s < sample.size(); ++s)
    signatures.row(static_cast<Eigen::Index>(s)) = distances.row(sample[s]);
  const int nearest = std::min(std::max(neighbours, 1), count - 1);
  std::vector<Pair> pairs(static_cast<size_t>(count) * static_cast<size_t>(nearest));
  pool.forEach(count, [&](int i) {
    std::vector<std::pair<double, int>> others;
    for (int j = 0; j < count; ++j)
      if (j != i) others.emplace_back((signatures.col(j) - signatures.col(i)).squaredNorm(), j);
    std::nth_element(others.begin(), others.begin() + (nearest - 1), others.end());
    for (int k = 0; k < nearest; ++k) {
      const int j = others[static_cast<size_t>(k)].second;
      pairs[static_cast<size_t>(i) * static_cast<size_t>(nearest) + static_cast<size_t>(k)] = {
          std::max(i, j), std::min(i, j)};
    }
  });
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(),
                             [&](const Pair& p) { return distances(p.first, p.second) < unknown; }),
              pairs.end());
  return pairs;
}

}  // namespace

Eigen::MatrixXd shapeDistances(const Sequence& sequence, ThreadPool& pool,
                               const ShapeComparison& comparison) {
  sequence.prepare(pool);
  const int count = sequence.size();
  Eigen::MatrixXd distances = Eigen::MatrixXd::Constant(count, count, unknown);
  distances.diagonal().setZero();
  if (count <= comparison.allPairsUpTo) {
    std::vector<Pair> all;
    for (int i = 0; i < count; ++i)
      for (int j = 0; j < i; ++j) all.emplace_back(i, j);
    compare(sequence, all, pool, distances);
    return distances;
  }
  const std::vector<int> sample = evenlySpread(count, comparison.sample);
  compare(sequence, pairsWith(sample, count), pool, distances);
  compare(sequence, likelyNeighbours(distances, sample, comparison.neighbours, pool), pool,
          distances);
  return distances;
}

PropagationTree minimumSpanningTree(const Eigen::MatrixXd& distances, int root) {
  const int layers = static_cast<int>(distances.rows());
  if (distances.cols() != layers || distances.array().isNaN().any() ||
      distances != distances.transpose())
    throw ArgumentError(
        "Distances between layers form a square, symmetric matrix of numbers; given is one of " +
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
    if (!(distances(next, tree.parent[next]) < unknown))
      throw ArgumentError("Distances between layers leave some without a way to layer " +
                          std::to_string(root) + ".");
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

int mostCentral(const Eigen::MatrixXd& distances) {
  const Eigen::Index count = distances.rows();
  // Some were compared with all: those alone count, for every surface alike.
  std::vector<Eigen::Index> all;
  for (Eigen::Index j = 0; j < count; ++j)
    if (distances.col(j).allFinite()) all.push_back(j);
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(count), others = Eigen::VectorXd::Zero(count);
  for (const Eigen::Index j : all)
    for (Eigen::Index i = 0; i < count; ++i)
      if (i != j) {
        sums[i] += distances(i, j);
        ++others[i];
      }
  Eigen::Index central = 0;
  (sums.array() / others.array().max(1)).minCoeff(&central);
  return static_cast<int>(central);
}

SimilarityTree similarityTree(const Sequence& sequence, int root, ThreadPool& pool) {
  star(sequence.size(), root);  // checks the root before the work
  Eigen::MatrixXd distances = shapeDistances(sequence, pool);
  PropagationTree tree = minimumSpanningTree(distances, root);
  return {std::move(tree), std::move(distances)};
}

}  // namespace sphere_propagation
