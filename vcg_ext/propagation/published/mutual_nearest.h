// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Pairs of vertices that are each other's nearest: step 4c of the paper.

#include <vector>

#include "vcg_ext/mesh/vertex_locator.h"

namespace sphere_propagation {

/// A vertex of a surface and the vertex of its reference that it corresponds to.
struct VertexPair {
  int target;
  int reference;
  friend bool operator==(const VertexPair& a, const VertexPair& b) {
    return a.target == b.target && a.reference == b.reference;
  }
};

/// The relation R of the paper's step 4c: all pairs (v, w) such that w is the reference vertex
/// nearest to v and v the target vertex nearest to w. Of equally near vertices the one with the
/// smallest index counts as nearest (the paper breaks ties arbitrarily), so no vertex is in two
/// pairs, and there is always at least one pair. target, reference: the vertices of the two
/// surfaces, aligned. Returns the pairs by ascending target vertex.
std::vector<VertexPair> mutualNearest(const VertexLocator& target, const VertexLocator& reference);

}  // namespace sphere_propagation
