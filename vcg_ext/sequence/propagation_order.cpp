// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/propagation_order.h"

#include "vcg_ext/base/error.h"
#include "vcg_ext/sequence/similarity_tree.h"

namespace sphere_propagation {
namespace {

PropagationTree givenTree(const PropagationOrder& order, const Sequence& sequence, int root) {
  star(sequence.size(), root);  // checks the root
  PropagationTree tree = givenOrder(order.parents);
  if (tree.size() != sequence.size())
    throw ArgumentError("The order of propagation is one of " + std::to_string(tree.size()) +
                        " surfaces, but there are " + std::to_string(sequence.size()) + ".");
  if (tree.root() != root)
    throw ArgumentError("The parents' root (-1) is surface \"" + sequence.name(tree.root()) +
                        "\", but it is to be surface \"" + sequence.name(root) + "\".");
  return tree;
}

}  // namespace

PropagationTree makeTree(const PropagationOrder& order, const Sequence& sequence, int root,
                         ThreadPool& pool) {
  switch (order.kind) {
    case PropagationOrder::Kind::CyclicTime:
      return cyclicTimeOrder(sequence.size(), root);
    case PropagationOrder::Kind::SimilarityTree:
      return similarityTree(sequence, root, pool).tree;
    case PropagationOrder::Kind::Star:
      return star(sequence.size(), root);
    case PropagationOrder::Kind::Given:
      return givenTree(order, sequence, root);
    default:
      return timeOrder(sequence.size(), root);
  }
}

}  // namespace sphere_propagation
