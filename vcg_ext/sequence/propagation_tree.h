// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Who hands the map to whom: step 2 of the paper (the propagation tree), and the other orders on
/// offer.
///
/// Surfaces are numbered from 0 in the order of the list, which is time order where time matters.

#include <vector>

namespace sphere_propagation {

/// A rooted tree over surfaces. Each arc (parent, surface) is one propagation step.
struct PropagationTree {
  std::vector<int> parent;  ///< one entry per surface: whose map it gets; -1 for the root
  std::vector<int> order;   ///< all surfaces, the root first, parents before their children

  int size() const { return static_cast<int>(parent.size()); }
  int root() const { return order.front(); }
  /// The number of arcs between the root and each surface.
  std::vector<int> depths() const;
  /// The surfaces at each number of arcs from the root, in ascending order: those of one entry do
  /// not need each other.
  std::vector<std::vector<int>> levels() const;
  /// The surfaces that get their map from each surface, in ascending order.
  std::vector<std::vector<int>> children() const;
  /// The surface that would be the best root of the same tree: the one from which the farthest
  /// surface is the fewest arcs away; of equals the root itself, then the smallest.
  int centre() const;
  /// The number of arcs between a surface and the one farthest from it, whichever way the maps go.
  int farthestFrom(int layer) const;
};

/// An arc from one surface to another.
struct Arc {
  int from = -1, to = -1;
};

/// The paper's default root, floor(surfaces / 2), counted from 0. surfaces >= 1.
int defaultRoot(int surfaces);

/// Step 2 of the paper: the arcs (M_{i+1}, M_i) for i < t and (M_i, M_{i+1}) for i >= t, that is,
/// one chain from the root t back to the first surface and one on to the last. surfaces: how many,
/// >= 1; root: 0 .. surfaces - 1. Throws ParameterError when either is outside its range.
PropagationTree timeOrder(int surfaces, int root);

/// The same for surfaces that form a cycle (a heart beat): from the root on through floor(surfaces
/// / 2) surfaces, and back through the others, so that no chain is longer than half the cycle.
/// Parameters and errors as in timeOrder.
PropagationTree cyclicTimeOrder(int surfaces, int root);

/// The arc that cyclicTimeOrder leaves out, where its two branches meet: from the last surface of
/// the one that goes forward to the last of the other. surfaces >= 2; errors as in timeOrder.
Arc closingArc(int surfaces, int root);

/// A tree that an arc makes a circle, as the surfaces lie on it.
struct ClosedCycle {
  std::vector<int> layers;  ///< once round, the root first; empty where tree and arc make no circle
                            ///< of all surfaces
  int forward = 0;  ///< where in it the arc begins: the surfaces up to there make one branch, the
                    ///< others the other
  /// The arcs that carry the branch that goes forward, or the other one, on to the surfaces of the
  /// other branch.
  std::vector<Arc> arcsBeyond(bool forwardBranch) const;
};

/// The circle of a tree and an arc that joins the ends of its two branches (closingArc), in the
/// direction of the arc.
ClosedCycle closedCycle(const PropagationTree& tree, const Arc& closing);

/// Every surface gets its map from the root itself. Parameters and errors as in timeOrder.
PropagationTree star(int surfaces, int root);

/// The order that the user gives ("the order may also be given", discussion of the paper).
/// parents: one entry per surface, the number of the surface its map comes from, -1 for the root.
/// Throws ParameterError, which names the surface and what to do, when there is not exactly one
/// root, when a number is no surface's, or when surfaces hand the map round in a circle.
PropagationTree givenOrder(const std::vector<int>& parents);

}  // namespace sphere_propagation
