// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Both ways round a closed cycle.
///
/// A tree of a cycle has two branches that meet half way round: each surface is fitted from one
/// side. Carried on to the root, each branch reaches the surfaces of the other one, too, and what
/// the two say of a surface is averaged: their drift is of different arcs.

#include <Eigen/Core>
#include <vector>

#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/propagation/motion/motion_fit.h"
#include "vcg_ext/propagation/motion/motion_model.h"
#include "vcg_ext/sequence/propagation_tree.h"

namespace sphere_propagation {

/// Carries each branch on to the surfaces of the other one, the arcs in the order of the cycle.
/// cycle: closedCycle() of the tree, not empty; sequence: the surfaces; fit: of the tree; prior: of
/// that fit. pool: the two chains do not need each other. What the fit lost is of no use to start
/// with, so it takes three iterations instead of one to go there. Returns the coefficients that
/// come to each surface the other way round; zero at the root.
std::vector<Eigen::VectorXd> fitOtherWayRound(const MotionModel& model, const Sequence& sequence,
                                              const ClosedCycle& cycle, const MotionFit& fit,
                                              const MotionPrior& prior, ThreadPool& pool,
                                              const MotionAnchors& anchors = {});

/// The share of the chain that goes forward in the average at a number of steps from the root, 0 <
/// step < surfaces: the mean of 1/2 and of (surfaces - step) / surfaces. The latter is right where
/// error is gathered along the arcs alone and alike on all; but each fit has an error of its own
/// besides, which no chain is the freer of for being shorter.
double forwardShare(int step, int surfaces);

/// Whether two motions of the nodes onto a surface are at most maxEdgesApart apart, on average.
bool agree(const MotionModel& model, const PreparedSurface& layer, const Eigen::VectorXd& a,
           const Eigen::VectorXd& b);

/// Averages the two where both are there and they agree (maxEdgesApart); elsewhere what the tree
/// brought.
std::vector<Eigen::VectorXd> averageOfBothWays(const MotionModel& model, const Sequence& sequence,
                                               const ClosedCycle& cycle,
                                               const std::vector<Eigen::VectorXd>& brought,
                                               const std::vector<Eigen::VectorXd>& otherWayRound);

}  // namespace sphere_propagation
