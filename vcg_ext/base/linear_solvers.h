// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Eigen's solvers that several rooms need, compiled once: compilers take long for them.

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>

namespace sphere_propagation {

/// matrix = vectors diag(values) vectors^T, values ascending, vectors orthonormal columns.
struct SymmetricEigen {
  Eigen::Vector3d values;
  Eigen::Matrix3d vectors;
};

/// symmetric: its lower triangle is read.
SymmetricEigen eigenOf(const Eigen::Matrix3d& symmetric);

/// L D L^T of a sparse symmetric matrix, positive definite or nearly so. Factorise first, solve
/// often; matrices of one pattern share its analysis.
class SparseCholesky {
 public:
  using Matrix = Eigen::SparseMatrix<double>;
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(const SparseCholesky&) = delete;
  SparseCholesky& operator=(const SparseCholesky&) = delete;
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  /// matrix: its lower triangle is read.
  void analysePattern(const Matrix& matrix);
  /// Of the pattern that was analysed last.
  void factorise(const Matrix& matrix);
  void compute(const Matrix& matrix);
  /// Whether the last factorisation met no zero pivot.
  bool succeeded() const;
  /// right: one right-hand side per column.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const;

 private:
  struct Solver;
  std::unique_ptr<Solver> solver_;
};

}  // namespace sphere_propagation
