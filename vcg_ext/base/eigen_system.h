// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Eigenvalues and vectors of symmetric matrices of any size, compiled once; `linear_solvers` has
/// them for 3 by 3.

#include <Eigen/Core>

namespace sphere_propagation {

/// matrix = vectors diag(values) vectors^T, values ascending, vectors orthonormal columns.
struct EigenSystem {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

/// symmetric: finite; its lower triangle is read.
EigenSystem eigenSystemOf(const Eigen::MatrixXd& symmetric);

}  // namespace sphere_propagation
