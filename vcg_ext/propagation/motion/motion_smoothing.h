// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The motion of all surfaces at once, from what all of them say.
///
/// Arc by arc, each fit takes the surface before it for exact, and reads its errors as
/// motion; the root's come back in every surface. Here all coefficients z_t minimise together
///
///   sum over surfaces t, nodes i of A_i w_it (A0/2) / (kappa At^2) *
///       (m_it . (p_it - X_i) - m_it . B_i z_t - (m_it . n_i) e_i - o_it)^2
///   + sum over arcs (s, t) of (z_t - z_s)^T Sigma^-1 (z_t - z_s) / a_st
///   + the norms of e and of each o_t in their covariances,            z = 0 at the root,
///
/// with the data of motion_fit.h, linearised where the fits along the tree ended, and
///   e    the error of the root's surface along its normal n, the same in all surfaces,
///   o_t  that of surface t (surface_errors.h: flat parts err as a whole), of standard
///        deviation tau mean edges of the surface; e of twice that, since nothing averages it away;
///   a_st how much the surfaces move along their normals on the arc: the median over the nodes of
///        the squared change, to the power of 0.7, as a share of the mean of all arcs, at least
///        0.05.
///
/// Two figures are the sequence's own. tau = 10 (d - 0.07), from 0.03 to 0.6, d the root mean
/// square over surfaces of the offset, in standard deviations, that the part of the surface which
/// errs most alike has with tau = 0.6, kappa = 5. kappa is the largest of 1.25, 1.25 sqrt 2, ... 10
/// with which the median distance of nodes from the surfaces (e taken off) is at most 2 % above the
/// smallest seen: the stiffest motion that the surfaces do not contradict.
///
/// Sigma is what was learnt from the arcs, with variances times 0.45 (local), 0.7 (translation), 6
/// (strain) and 1 (rotation): arc by arc, a prior that leaves strain this free would take errors of
/// surfaces for it; here these have their own unknowns, and a stiff strain is what lags behind the
/// shortening of a heart along its axis.
///
/// H. E. Rauch, F. Tung, C. T. Striebel, Maximum likelihood estimates of linear dynamic systems,
/// 1965 (smoothing); solved by conjugate gradients, since in a cycle, and with e, all surfaces hang
/// together.

#include <Eigen/Core>
#include <vector>

#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/propagation/motion/motion_model.h"
#include "vcg_ext/propagation/motion/motion_prior.h"
#include "vcg_ext/sequence/propagation_tree.h"
#include "vcg_ext/sequence/sequence.h"

namespace sphere_propagation {

struct SmoothedMotion {
  std::vector<Eigen::VectorXd> coefficients;  ///< of each surface; of those on no arc as they were
  double noise = 0;                           ///< kappa
  double errorInEdges = 0;                    ///< tau
  Eigen::VectorXd rootError;  ///< e, #N, in the unit of length: what the root's surface lacks
                              ///< outwards
  /// Where asked for: P of motion_uncertainty.h, one of size 0 for surfaces on no arc.
  std::vector<Eigen::MatrixXd> covariances;
};

/// Sigma^-1 as above, from the one that was learnt (motion_learning.h).
MotionPrior priorForAllAtOnce(const MotionPrior& learnt);

/// sequence: the surfaces; root: the moving one; arcs: between surfaces, the root among them, which
/// hang together; start: coefficients of each surface, zero at the root, with which the nodes lie
/// near it; prior: of the motion along an arc, Sigma^-1. pool: who does the work, with the same
/// result whatever the number of threads. withCovariances: whether they are asked for.
SmoothedMotion smoothMotion(const MotionModel& model, const Sequence& sequence, int root,
                            const std::vector<Arc>& arcs, const std::vector<Eigen::VectorXd>& start,
                            const MotionPrior& prior, ThreadPool& pool,
                            bool withCovariances = false);

}  // namespace sphere_propagation
