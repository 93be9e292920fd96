// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The order "Similarity tree" for surfaces that are in no order: everyone gets the map from
/// somebody alike. The paper names an automatic order for unordered shapes as future work. (The
/// orders in time: propagation_tree.h.)

#include <Eigen/Core>
#include <vector>

#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/sequence/propagation_tree.h"
#include "vcg_ext/sequence/sequence.h"

namespace sphere_propagation {

/// How much every two surfaces differ: #surfaces by #surfaces, symmetric, zero diagonal, in the
/// unit of the vertices.
///
/// The distance of two surfaces is the root mean square distance of about 100 vertices of one,
/// spread evenly, from the other's surface, and the other way round, averaged; after a rigid
/// alignment by closest points from the best of five poses: as they are, and the four that lay
/// principal axes on principal axes. Scale counts, rotation and translation do not. Deterministic.
/// 30 surfaces of 5000 vertices take less than a second. pool: who does the work, with the same
/// result whatever the number of threads.
Eigen::MatrixXd shapeDistances(const Sequence& sequence, ThreadPool& pool);

/// The tree of least total distance (R. C. Prim, Shortest connection networks and some
/// generalizations, 1957), grown from the root; of equal distances the smallest surface goes first,
/// and to the smallest parent. distances: #surfaces by #surfaces, symmetric, finite; root: from 0.
/// Throws ParameterError when the matrix is not square and symmetric or the root is no surface.
PropagationTree minimumSpanningTree(const Eigen::MatrixXd& distances, int root);

struct SimilarityTree {
  PropagationTree tree;
  Eigen::MatrixXd distances;  ///< of shapeDistances
};

/// minimumSpanningTree of shapeDistances. Throws ParameterError when the root is no surface.
SimilarityTree similarityTree(const Sequence& sequence, int root, ThreadPool& pool);

}  // namespace sphere_propagation
