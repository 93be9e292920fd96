// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The thin singular value decomposition, compiled once: Eigen's takes a compiler long.

#include <Eigen/Core>

namespace sphere_propagation {

/// matrix = u diag(s) v^T with n = min(#R, #C): u #R by n and v #C by n with orthonormal columns, s
/// falling, >= 0.
struct ThinSvd {
  Eigen::MatrixXd u;
  Eigen::VectorXd s;
  Eigen::MatrixXd v;
};

/// matrix: #R by #C, finite.
ThinSvd thinSvd(const Eigen::MatrixXd& matrix);

}  // namespace sphere_propagation
