// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/propagation_tree.h"

#include <algorithm>
#include <string>
#include <utility>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

std::vector<std::vector<int>> childrenOf(const std::vector<int>& parent) {
  std::vector<std::vector<int>> children(parent.size());
  for (size_t i = 0; i < parent.size(); ++i)
    if (parent[i] >= 0) children[parent[i]].push_back(static_cast<int>(i));
  return children;
}

/// The tree of these arcs, breadth first. Surfaces on or behind a circle are in no order: the
/// caller looks for them.
PropagationTree treeOf(std::vector<int> parent, int root) {
  const std::vector<std::vector<int>> children = childrenOf(parent);
  std::vector<int> order{root};
  order.reserve(parent.size());
  for (size_t next = 0; next < order.size(); ++next) {
    const std::vector<int>& of = children[order[next]];
    order.insert(order.end(), of.begin(), of.end());
  }
  return {std::move(parent), std::move(order)};
}

void requireRoot(int surfaces, int root) {
  if (surfaces < 1) throw ParameterError(Finding(Fault::NoSurface));
  if (root < 0 || root >= surfaces)
    throw ParameterError(Finding(Fault::RootOutOfRange).of(1, root).at(root, 0, surfaces - 1));
}

}  // namespace

std::vector<int> PropagationTree::depths() const {
  std::vector<int> depth(parent.size(), 0);
  for (int i : order)
    if (parent[i] >= 0) depth[i] = depth[parent[i]] + 1;
  return depth;
}

std::vector<std::vector<int>> PropagationTree::levels() const {
  const std::vector<int> depth = depths();
  std::vector<std::vector<int>> found;
  for (size_t i = 0; i < depth.size(); ++i) {
    const auto level = static_cast<size_t>(depth[i]);
    if (found.size() <= level) found.resize(level + 1);
    found[level].push_back(static_cast<int>(i));
  }
  return found;
}

std::vector<std::vector<int>> PropagationTree::children() const { return childrenOf(parent); }

int PropagationTree::farthestFrom(int layer) const {
  std::vector<std::vector<int>> neighbours = childrenOf(parent);
  for (size_t i = 0; i < parent.size(); ++i)
    if (parent[i] >= 0) neighbours[i].push_back(parent[i]);
  std::vector<int> distance(parent.size(), -1), queue{layer};
  distance[layer] = 0;
  for (size_t next = 0; next < queue.size(); ++next)
    for (int other : neighbours[queue[next]]) {
      if (distance[other] >= 0) continue;
      distance[other] = distance[queue[next]] + 1;
      queue.push_back(other);
    }
  return distance[queue.back()];
}

int PropagationTree::centre() const {
  int best = root(), least = farthestFrom(best);
  for (int i = 0; i < size(); ++i) {
    const int farthest = farthestFrom(i);
    if (farthest >= least) continue;
    least = farthest;
    best = i;
  }
  return best;
}

int defaultRoot(int surfaces) {
  requireRoot(surfaces, 0);
  return surfaces / 2;
}

PropagationTree timeOrder(int surfaces, int root) {
  requireRoot(surfaces, root);
  std::vector<int> parent(static_cast<size_t>(surfaces));
  for (int i = 0; i < surfaces; ++i) parent[i] = i < root ? i + 1 : i - 1;
  parent[root] = -1;
  return treeOf(std::move(parent), root);
}

PropagationTree cyclicTimeOrder(int surfaces, int root) {
  requireRoot(surfaces, root);
  std::vector<int> parent(static_cast<size_t>(surfaces));
  for (int step = 0; step < surfaces; ++step) {  // phases after the root, round the cycle
    const int from = step <= surfaces / 2 ? step - 1 : step + 1;
    parent[(root + step) % surfaces] = (root + from + surfaces) % surfaces;
  }
  parent[root] = -1;
  return treeOf(std::move(parent), root);
}

Arc closingArc(int surfaces, int root) {
  requireRoot(surfaces, root);
  const int from = (root + surfaces / 2) % surfaces;
  return {from, (from + 1) % surfaces};
}

std::vector<Arc> ClosedCycle::arcsBeyond(bool forwardBranch) const {
  const int count = static_cast<int>(layers.size());
  std::vector<Arc> arcs;
  const auto at = [&](int step) { return layers[step % count]; };
  if (forwardBranch)
    for (int step = forward + 1; step < count; ++step) arcs.push_back({at(step - 1), at(step)});
  else
    for (int step = forward; step > 0; --step) arcs.push_back({at(step + 1), at(step)});
  return arcs;
}

ClosedCycle closedCycle(const PropagationTree& tree, const Arc& closing) {
  ClosedCycle cycle;
  for (int i = closing.from; i >= 0; i = tree.parent[i]) cycle.layers.push_back(i);
  std::reverse(cycle.layers.begin(), cycle.layers.end());
  cycle.forward = static_cast<int>(cycle.layers.size()) - 1;
  for (int i = closing.to; i >= 0 && i != tree.root(); i = tree.parent[i])
    cycle.layers.push_back(i);
  std::vector<int> sorted = cycle.layers;
  std::sort(sorted.begin(), sorted.end());
  const bool once = std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end();
  if (!once || sorted.size() != tree.parent.size()) return {};
  return cycle;
}

PropagationTree star(int surfaces, int root) {
  requireRoot(surfaces, root);
  std::vector<int> parent(static_cast<size_t>(surfaces), root);
  parent[root] = -1;
  return treeOf(std::move(parent), root);
}

PropagationTree givenOrder(const std::vector<int>& parents) {
  const int surfaces = static_cast<int>(parents.size());
  requireRoot(surfaces, 0);
  int root = -1;
  for (int i = 0; i < surfaces; ++i) {
    if (parents[i] < -1 || parents[i] >= surfaces)
      throw ParameterError(Finding(Fault::ParentOutOfRange)
                               .of(1, i)
                               .amid(parents[i])
                               .at(parents[i], 0, surfaces - 1));
    if (parents[i] != -1) continue;
    if (root >= 0) throw ParameterError(Finding(Fault::SecondRoot).of(1, i).amid(root));
    root = i;
  }
  if (root < 0) throw ParameterError(Finding(Fault::NoRoot));

  PropagationTree tree = treeOf(parents, root);
  if (tree.order.size() == parents.size()) return tree;
  std::vector<bool> reached(parents.size(), false);
  for (int i : tree.order) reached[i] = true;
  int at = 0;
  while (reached[at]) ++at;
  for (int step = 0; step < surfaces; ++step) at = parents[at];  // from behind a circle into it
  for (int first = at, i = parents[first]; i != first; i = parents[i]) at = std::min(at, i);
  std::string circle = std::to_string(at);
  for (int i = parents[at]; i != at; i = parents[i]) circle += " <- " + std::to_string(i);
  throw ParameterError(
      Finding(Fault::Circle).of(1, at).amid(root).saying(circle + " <- " + std::to_string(at)));
}

}  // namespace sphere_propagation
