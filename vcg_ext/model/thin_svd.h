// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The thin singular value decomposition of many long columns, by way of their Gram matrix.

#include <Eigen/Core>

#include "vcg_ext/base/progress.h"
#include "vcg_ext/base/thread_pool.h"

namespace sphere_propagation {

/// matrix = u diag(s) v^T, u and v with orthonormal columns, s falling.
struct ThinSvd {
  Eigen::MatrixXd u;  ///< #R by min(left vectors asked for, #s)
  Eigen::VectorXd s;
  Eigen::MatrixXd v;  ///< #C by #s
};

/// Of a matrix of n = min(#R, #C): singular values above `rounding` with their right vectors, and
/// the first `leftVectors` of the left ones. O(n^2 max(#R, #C)).
///
/// Eigenvalues of a Gram matrix are squares, of which those below epsilon times the largest drown.
/// So only singular values within a factor of 300 are taken from one Gram matrix; what is
/// orthogonal to their vectors is small, and gets a Gram matrix of its own, as often as needed. The
/// relative error of a singular value is 1e-10 at most, as long as it is well above epsilon times
/// the largest.
///
/// pool: who does the work, with the same result whatever the number of threads.
ThinSvd thinSvd(const Eigen::MatrixXd& matrix, double rounding, Eigen::Index leftVectors,
                ThreadPool& pool, const Progress& progress = {});

}  // namespace sphere_propagation
