// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// How well the motion is known along the surface, where nothing but the prior says how it went.
///
/// Fits of motion are estimates of normal variables, so they come with a covariance P_t of the
/// coefficients of surface t. All at once (motion_smoothing.h) it is the posterior's; arc by arc
/// (motion_fit.h), where each fit takes the surface s before it for exact, that of the estimate's
/// error,
///
///   P_t = F^-1 + M P_s M^T,   F = H + Sigma^-1,   M = I - F^-1 H,
///
/// and of the average of both ways round a cycle, with the shares 1 - w and w,
///   (1 - w)^2 P_t + w^2 P'_t + 2 w (1 - w) F^-1 H F^-1,
/// as the two have the surface t in common. P is in units of A0/2, as Sigma is.
///
/// What is told of a node is one figure: the root of the mean variance of its two coordinates
/// along the surface, of which round errors exceed 2.45 times in 5 % of cases.
///
/// A covariance knows nothing of what its model gets wrong, and that grows with how far tissue has
/// come from the root: fields of other wavelengths than the prior's look much alike along the
/// normal. So what is reported is
///
///   s^2 = (0.75 s_P)^2 + (0.2 r)^2,
///
/// s_P that figure, r the root mean square over the nodes of how far the motion took them. The two
/// shares were chosen on seven sequences and hold on others (docs/propagation_robust.md).

#include <Eigen/Core>
#include <vector>

#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/propagation/motion/motion_cycle.h"
#include "vcg_ext/propagation/motion/motion_fit.h"
#include "vcg_ext/propagation/motion/motion_model.h"
#include "vcg_ext/sequence/propagation_tree.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

/// The blocks of a chain x_0 .. x_K-1, whose neighbours are bound to each other, and of unknowns s
/// that all of them share: the matrix of their joint precision is
///   blocks[k] + inTime(k, k) I        at x_k,
///   inTime(k, l) I                    between x_k and x_l,
///   coupling[k], shared               between x_k and s, and at s.
struct BoundChain {
  std::vector<Eigen::MatrixXd> blocks;
  Eigen::MatrixXd inTime;  ///< K by K; each x is bound to two others at most, in no cycle
  std::vector<Eigen::MatrixXd> coupling;
  Eigen::MatrixXd shared;
};

/// The covariance of each x_k, s integrated out.
std::vector<Eigen::MatrixXd> covariancesOf(const BoundChain& chain, ThreadPool& pool);

/// P of the surfaces of a fit along a tree; of size 0 at the root and where the fit is lost.
std::vector<Eigen::MatrixXd> covariancesAlongTree(const PropagationTree& tree, const MotionFit& fit,
                                                  ThreadPool& pool);

/// P of the averages of both ways round (averageOfBothWays), those along the tree given; averaged:
/// which surfaces are averages. The others keep theirs.
std::vector<Eigen::MatrixXd> covariancesOfBothWays(const ClosedCycle& cycle, const MotionFit& fit,
                                                   const std::vector<char>& averaged,
                                                   std::vector<Eigen::MatrixXd> alongTree);

/// s_P of each node, #N, in the unit of length. c: where the nodes are; covariance: P.
Eigen::VectorXd deviationsAlongSurface(const MotionModel& model, const Eigen::VectorXd& c,
                                       const Eigen::MatrixXd& covariance);

/// s of each node, #N, from the same.
Eigen::VectorXd uncertaintyOfNodes(const MotionModel& model, const Eigen::VectorXd& c,
                                   const Eigen::MatrixXd& covariance);

/// What the nodes have (#N), interpolated at the vertices of a surface that has its map: #V.
Eigen::VectorXd interpolatedAt(const MotionModel& model, const MappedSurface& map,
                               const Eigen::VectorXd& ofNodes);

}  // namespace sphere_propagation
