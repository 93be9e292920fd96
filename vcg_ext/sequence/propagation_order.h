// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Which surface hands its map to which: the orders on offer, as the user chooses among them.

#include <vector>

#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/sequence/propagation_tree.h"
#include "vcg_ext/sequence/sequence.h"

namespace sphere_propagation {

struct PropagationOrder {
  enum class Kind {
    Time,            ///< timeOrder: the paper's
    CyclicTime,      ///< cyclicTimeOrder
    SimilarityTree,  ///< similarity_tree.h: for shapes in no order
    Star,            ///< star
    Given,           ///< givenOrder: as the user says
  };
  Kind kind = Kind::Time;
  std::vector<int> parents = {};  ///< of Kind::Given: one entry per surface, -1 for the root

  /// Whether the tree depends on what the surfaces look like.
  bool goesByShape() const { return kind == Kind::SimilarityTree; }
};

/// The tree of this order with this root. Throws ParameterError when the root is no surface, or a
/// given order is no tree or has another root.
PropagationTree makeTree(const PropagationOrder& order, const Sequence& sequence, int root,
                         ThreadPool& pool);

}  // namespace sphere_propagation
