// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Fitting a motion model to a sequence of surfaces, one arc of a propagation tree after the other.
///
/// From surface s to surface t, c_t minimises
///   sum_i A_i w_i (m_i . (x_i(c_t) - p_i))^2 (A0/2) / (kappa At^2)
///     + (c_t - c_s)^T Sigma^-1 (c_t - c_s),
/// p_i the closest point of surface t whose face normal agrees with the template's normal, m_i the
/// normal of surface t there, w_i a robust weight, A0 and At the mean vertex areas of the moving
/// surface and of surface t. At is its area over its vertices, or over the geometric mean of their
/// number and 3000 where it has fewer. Point to plane only: where a surface slides along itself,
/// the prior Sigma decides. c counts in units of sqrt(A0/2), so that Sigma has no unit.

#include <Eigen/Core>
#include <vector>

#include "vcg_ext/base/dense_cholesky.h"
#include "vcg_ext/base/progress.h"
#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/propagation/motion/motion_anchors.h"
#include "vcg_ext/propagation/motion/motion_model.h"
#include "vcg_ext/propagation/motion/motion_prior.h"
#include "vcg_ext/sequence/propagation_tree.h"
#include "vcg_ext/sequence/sequence.h"

namespace sphere_propagation {

/// Normal equations of an arc's data term, linearised where its fit ended: H (c - c_s) = h.
struct ArcEquations {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd vector;
};

struct ArcFit {
  Eigen::VectorXd coefficients;
  ArcEquations equations;
  DenseCholesky factor;  ///< of H + Sigma^-1
  double distance = 0;   ///< mean, of the nodes from their closest points, when those were last
                         ///< looked for; NaN: none
};

/// Iterations of an arc's fit that starts where the last one ended, and of one that another fit has
/// gone before.
constexpr int arcIterations = 3, arcIterationsAgain = 2;

/// Fits one surface: closest points, a Newton step, and again. before: the coefficients of the
/// surface that it comes from; start: what to add to them to begin with, when H is that of the
/// first iteration throughout, as it says how far to step, not where to; or of size 0: nothing,
/// when H is computed at each. anchors: of the surface (motion_anchors.h); a fit without start
/// begins with what they and the prior say. H is with them, and Sigma as they widen it.
ArcFit fitArc(const MotionModel& model, const PreparedSurface& target,
              const Eigen::VectorXd& before, const MotionPrior& prior,
              const Eigen::VectorXd& start = {}, int iterations = arcIterations,
              const LayerAnchors* anchors = nullptr);

/// What a fit to a surface leaves for another one to the same surface with the same prior.
struct ArcSystem {
  const Eigen::MatrixXd& matrix;  ///< H
  const DenseCholesky& factor;    ///< of H + Sigma^-1
};

/// One iteration from a good start, with the H of another fit. Returns the coefficients.
Eigen::VectorXd fitArcAgain(const MotionModel& model, const PreparedSurface& target,
                            const Eigen::VectorXd& before, const MotionPrior& prior,
                            const Eigen::VectorXd& start, const ArcSystem& system,
                            const LayerAnchors* anchors = nullptr);

/// What lies farther apart than this, in mean edge lengths of the surface and on average, does not
/// belong together: a fit that leaves its nodes farther off has lost the surface, and so has one
/// that leaves the surface's vertices farther off; two motions that differ by more are not
/// averaged.
constexpr double maxEdgesApart = 2;

struct MotionFit {
  std::vector<Eigen::VectorXd> coefficients;  ///< of each surface; zero at the root
  std::vector<ArcEquations> equations;        ///< of each surface; empty at the root
  std::vector<DenseCholesky> factors;         ///< of H + Sigma^-1; empty at the root
  /// Of each surface, whether the fit lost it (maxEdgesApart). The surfaces behind it come from the
  /// nearest one up the tree that is not lost.
  std::vector<char> lost;
};

/// Fits all surfaces of a tree. sequence: the surfaces; tree: with the moving surface as root.
/// pool: who does the work; surfaces equally far from the root are fitted at once, with the same
/// result.
MotionFit fitMotion(const MotionModel& model, const Sequence& sequence, const PropagationTree& tree,
                    const MotionPrior& prior, ThreadPool& pool, const Progress& progress = {},
                    const MotionAnchors& anchors = {});

/// The same where the surfaces were fitted with another prior: each arc starts with the step that
/// it took there, so two iterations do. earlier: the coefficients of that fit.
MotionFit refitMotion(const MotionModel& model, const Sequence& sequence,
                      const PropagationTree& tree, const MotionPrior& prior,
                      const std::vector<Eigen::VectorXd>& earlier, ThreadPool& pool,
                      const Progress& progress = {}, const MotionAnchors& anchors = {});

}  // namespace sphere_propagation
