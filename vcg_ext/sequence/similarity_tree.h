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

/// Which pairs of surfaces are compared.
struct ShapeComparison {
  /// So many surfaces or fewer: all pairs. More: each with the sample, and with those that the
  /// sample says are the most alike, so that the cost grows with the number of surfaces alone.
  int allPairsUpTo = 200;
  int sample = 32;      ///< surfaces, evenly spread over the list
  int neighbours = 10;  ///< of each surface, at least
};

/// How much every two surfaces differ: #surfaces by #surfaces, symmetric, zero diagonal, in the
/// unit of the vertices; infinite where a pair was not compared.
///
/// The distance of two surfaces is the root mean square distance of about 100 vertices of one,
/// spread evenly, from the other's surface, and the other way round, averaged; after a rigid
/// alignment by closest points from the best of five poses: as they are, and the four that lay
/// principal axes on principal axes. Scale counts, rotation and translation do not. Deterministic.
/// 30 surfaces of 5000 vertices take less than a second. pool: who does the work, with the same
/// result whatever the number of threads.
///
/// Neighbours of a surface, where not all pairs are compared, are those whose distances from the
/// sample are the most like its own (root mean square): by the triangle inequality no surface that
/// is near can have distances that differ much (S. Brin, Near neighbor search in large metric
/// spaces, 1995).
Eigen::MatrixXd shapeDistances(const Sequence& sequence, ThreadPool& pool,
                               const ShapeComparison& comparison = {});

/// The tree of least total distance (R. C. Prim, Shortest connection networks and some
/// generalizations, 1957), grown from the root; of equal distances the smallest surface goes first,
/// and to the smallest parent. distances: #surfaces by #surfaces, symmetric, infinite where there
/// is to be no arc; root: from 0. Throws ParameterError when the matrix is not square and
/// symmetric, when finite distances do not join all surfaces, or the root is no surface.
PropagationTree minimumSpanningTree(const Eigen::MatrixXd& distances, int root);

/// The medoid: the surface whose mean distance from the others is the least; of equals the first.
/// Where not all pairs were compared, from those that all were compared with (D. Eppstein and J.
/// Wang, Fast approximation of centrality, 2004). distances: of shapeDistances, of one surface or
/// more.
int mostCentral(const Eigen::MatrixXd& distances);

struct SimilarityTree {
  PropagationTree tree;
  Eigen::MatrixXd distances;  ///< of shapeDistances
};

/// minimumSpanningTree of shapeDistances. Throws ParameterError when the root is no surface.
SimilarityTree similarityTree(const Sequence& sequence, int root, ThreadPool& pool);

}  // namespace sphere_propagation
