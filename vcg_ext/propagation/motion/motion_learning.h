// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The prior of motion learnt from the sequence itself.

#include <Eigen/Core>
#include <vector>

#include "vcg_ext/base/progress.h"
#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/propagation/motion/motion_anchors.h"
#include "vcg_ext/propagation/motion/motion_model.h"
#include "vcg_ext/propagation/motion/motion_prior.h"
#include "vcg_ext/sequence/propagation_tree.h"
#include "vcg_ext/sequence/sequence.h"

namespace sphere_propagation {

struct LearntPrior {
  MotionPrior prior;
  MotionVariances variances;                  ///< that it was drawn towards
  std::vector<Eigen::VectorXd> coefficients;  ///< of the fit that it was learnt from
};

/// Learns how much this sequence translates, strains and rotates from arc to arc, then the full
/// covariance: (1) a fit with a wide prior; (2) expectation-maximisation of the three affine
/// variances over its arcs, the local coefficients integrated out and the noise tempered; (3) of
/// the full covariance, drawn towards (2), where what an arc leaves uncertain is taken from the
/// mean of all arcs' equations. With anchors, (2) has a fourth variance, of twists
/// (motion_basis.h), and (3) is drawn towards them as well: few points say how one end turns
/// against the other only where it is expected to do so as a whole. For a dozen surfaces or more,
/// in whatever order: also where it is none in time, what is learnt is better than the fixed prior,
/// or as good (measured in docs/propagation_robust.md).
LearntPrior learnMotionPrior(const MotionModel& model, const Sequence& sequence,
                             const PropagationTree& tree, ThreadPool& pool,
                             const Progress& progress = {}, const MotionAnchors& anchors = {});

}  // namespace sphere_propagation
