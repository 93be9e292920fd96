// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A Gaussian model of how a population deforms, learnt from what its surfaces show: how far they
/// lie along the normal, and not how landmarks slide along them.

#include <vector>

#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/groupwise/population_pose.h"

namespace sphere_propagation {

struct PopulationModelParameters {
  /// beta times the variance per coordinate: how much the surfaces count against the prior.
  double surfacePrecision = 1000;
  double priorShapes = 2;  ///< for how many shapes the prior covariance counts
  int rounds = 12;         ///< of expectation and maximisation
};

struct PopulationFit {
  std::vector<Points> expected;  ///< where the landmarks of each shape are expected, #N by 3
  Eigen::VectorXd residuals;     ///< per shape, root mean square of what is left along the normal
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
/// pose: in units of the shapes' radius; normals: of the aligned landmarks, one #N by 3 per shape.
PopulationFit fitPopulation(const PopulationPose& pose, const std::vector<Points>& normals,
                            const PopulationModelParameters& parameters, ThreadPool& pool);

}  // namespace sphere_propagation
