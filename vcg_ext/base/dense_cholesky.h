// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Cholesky decompositions of dense matrices of any size, compiled once: compilers take long for
/// them.

#include <Eigen/Core>

namespace sphere_propagation {

/// Factorise once, solve often. The results are those of Eigen's `LLT`.
class DenseCholesky {
 public:
  DenseCholesky() = default;
  /// matrix: symmetric positive definite, of which the lower triangle is read.
  explicit DenseCholesky(Eigen::MatrixXd matrix);

  /// Whether every pivot was above zero.
  bool succeeded() const { return succeeded_; }
  /// right: one right-hand side per column; for the vector there is an overload.
  Eigen::MatrixXd solve(Eigen::MatrixXd right) const;
  Eigen::VectorXd solve(Eigen::VectorXd right) const;
  /// L^-1 right, and L^-T right.
  Eigen::MatrixXd solveLower(Eigen::MatrixXd right) const;
  Eigen::MatrixXd solveUpper(Eigen::MatrixXd right) const;

 private:
  Eigen::MatrixXd lower_;  // and above the diagonal what the matrix had there
  bool succeeded_ = false;
};

/// The solution of matrix x = right by L D L^T with pivots. matrix: symmetric, positive definite or
/// nearly so; its lower triangle is read.
Eigen::VectorXd solveSymmetric(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right);

}  // namespace sphere_propagation
