// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// How well the models of all shapes but one describe the one that was left out.

#include <Eigen/Core>

#include "vcg_ext/base/progress.h"
#include "vcg_ext/base/thread_pool.h"

namespace sphere_propagation {

/// Row k, column m - 1: the distance |x_k - x'_k(m)| of shape k from its best approximation by the
/// first m modes of the model of all other shapes, m <= modes. That model has #K - 2 modes at most;
/// where it has fewer than m, all are used.
///
/// Nothing is decomposed again. With rows x_k of the scores, D = diag of their squared singular
/// values and rho = #K / (#K - 1), the others' scatter about their own mean is
///   D - rho x_k x_k^T,    and the shape lies at rho x_k from that mean.
/// Its eigenvalues mu are the zeros of the secular equation (G. H. Golub, Some modified matrix
/// eigenvalue problems, 1973)
///   rho sum_j x_kj^2 / (d_j - mu) = 1,    one between each two d_j;
/// the square of rho x_k along the eigenvector of mu is 1 / sum_j x_kj^2 / (d_j - mu)^2, so that no
/// eigenvector is needed either: O(#M) for one mode of one shape.
///
/// scores: #K by #M, K >= 2, centred, orthogonal columns of falling length > 0, as ShapeModel has
/// them; modes <= #M; pool: who does the work, with the same result whatever the number of threads.
Eigen::MatrixXd leaveOneOut(const Eigen::MatrixXd& scores, Eigen::Index modes, ThreadPool& pool,
                            const Progress& progress = {});

/// What leaveOneOut takes the distances from: row m - 1 are the scores of x'_k(m), for one shape k.
/// The vector of mu has the entries x_kj / (d_j - mu), so that each mode costs O(#M) here, too.
Eigen::MatrixXd leftOutApproximations(const Eigen::MatrixXd& scores, Eigen::Index shape,
                                      Eigen::Index modes);

}  // namespace sphere_propagation
