// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/linear_solvers.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>

namespace sphere_propagation {

SymmetricEigen eigenOf(const Eigen::Matrix3d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

struct SparseCholesky::Solver : Eigen::SimplicialLDLT<Matrix, Eigen::Lower> {};

SparseCholesky::SparseCholesky() : solver_(std::make_unique<Solver>()) {}
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

void SparseCholesky::analysePattern(const Matrix& matrix) { solver_->analyzePattern(matrix); }
void SparseCholesky::factorise(const Matrix& matrix) { solver_->factorize(matrix); }
void SparseCholesky::compute(const Matrix& matrix) { solver_->compute(matrix); }
bool SparseCholesky::succeeded() const { return solver_->info() == Eigen::Success; }

Eigen::MatrixXd SparseCholesky::solve(const Eigen::MatrixXd& right) const {
  return solver_->solve(right);
}

}  // namespace sphere_propagation
