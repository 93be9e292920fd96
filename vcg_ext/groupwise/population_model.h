// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A Gaussian model of how a population deforms, learnt from what its surfaces show: how far they
/// lie along the normal, and not how landmarks slide along them.

#include <vector>

#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/groupwise/population_anchors.h"
#include "vcg_ext/groupwise/population_pose.h"

namespace sphere_propagation {

struct PopulationModelParameters {
  /// beta times the variance per coordinate: how much the surfaces count against the prior.
  double surfacePrecision = 1000;
  double priorShapes = 2;  ///< for how many shapes the prior covariance counts
  int rounds = 12;         ///< of expectation and maximisation
};

/// What an anchor counts beside all landmarks together, whose precision is beta.
double shareOf(const PlacedAnchor& anchor, double beta);

struct PopulationFit {
  std::vector<Points> expected;  ///< where the landmarks of each shape are expected, #N by 3
  Eigen::VectorXd residuals;     ///< per shape, root mean square of what is left along the normal
  Eigen::VectorXd trust;         ///< per shape, 0 to 1: how much the model was learnt from it
  double precision = 0;          ///< beta
};

/// The landmarks of shape k are x_k = mean + B c_k + what slides along the surface, with c_k ~
/// N(mu, Sigma). B: 240 columns of a kernel of smooth vector fields and twelve affine ones on the
/// mean shape (motion_basis.h). Observed are n_kj . (x_kj - mean_j) with precision beta w_j, w_j
/// the landmarks' shares of area:
///
///   H_k = sum_j w_j (B_j^T n_kj) (B_j^T n_kj)^T,  h_k = sum_j w_j B_j^T n_kj n_kj . (x_kj -
///   mean_j), E: c_k = (beta H_k + Sigma^-1)^-1 (beta h_k + Sigma^-1 mu), M: mu = mean of c_k,  (K
///   + p) Sigma = sum_k (c_k - mu) (c_k - mu)^T
///                                         + K (beta H + Sigma^-1)^-1 + p Sigma_0,
///
/// H the mean of the H_k, Sigma_0 the prior (each coordinate of a landmark varies as much as they
/// do now), p the number of shapes that it counts for. The posterior covariance in M is what keeps
/// the directions that no surface shows at their prior variance: without it they would shrink round
/// by round, and landmarks would gather where that makes the variance small, as they do when a
/// description length is minimised.
///
/// Shapes that do not belong would spoil this: each is a mode of its own, and moves what the others
/// are expected to be. So sums over shapes are weighted by a trust, found by turns with the model:
/// with m_k the squared Mahalanobis distance of c_k from the model of the others (without shape k,
/// whose part in Sigma is of rank one), trust is 1 up to six times what three quarters of the
/// shapes stay below (and up to 60, since members of few modes are all close), 0 from twice that
/// on. At first those count that differ least along their normals, three quarters fully (as the
/// concentration steps of P. J. Rousseeuw and K. Van Driessen, A fast algorithm for the minimum
/// covariance determinant estimator, 1999, start), so that two that are alike do not vouch for each
/// other. The less trusted shapes are expected somewhere, too, and move there. Fewer than five
/// shapes are all trusted.
///
/// Anchors add observations that lie in no plane: y - mean(u) with precision 1 / sd^2 in each
/// coordinate, but none counts for more than all landmarks do.
///
/// pose: in units of the shapes' radius; normals: of the aligned landmarks, one #N by 3 per shape;
/// anchors: by shape, their points aligned as well, or empty.
PopulationFit fitPopulation(const PopulationPose& pose, const std::vector<Points>& normals,
                            const PopulationModelParameters& parameters, ThreadPool& pool,
                            const std::vector<std::vector<PlacedAnchor>>& anchors = {});

}  // namespace sphere_propagation
