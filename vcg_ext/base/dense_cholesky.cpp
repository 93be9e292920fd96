// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/dense_cholesky.h"

#include <Eigen/Cholesky>
#include <utility>

namespace sphere_propagation {

DenseCholesky::DenseCholesky(Eigen::MatrixXd matrix) : lower_(std::move(matrix)) {
  succeeded_ = Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>>(lower_).info() == Eigen::Success;
}

Eigen::MatrixXd DenseCholesky::solveLower(Eigen::MatrixXd right) const {
  lower_.triangularView<Eigen::Lower>().solveInPlace(right);
  return right;
}

Eigen::MatrixXd DenseCholesky::solveUpper(Eigen::MatrixXd right) const {
  lower_.triangularView<Eigen::Lower>().transpose().solveInPlace(right);
  return right;
}

Eigen::MatrixXd DenseCholesky::solve(Eigen::MatrixXd right) const {
  return solveUpper(solveLower(std::move(right)));
}

Eigen::VectorXd DenseCholesky::solve(Eigen::VectorXd right) const {
  lower_.triangularView<Eigen::Lower>().solveInPlace(right);
  lower_.triangularView<Eigen::Lower>().transpose().solveInPlace(right);
  return right;
}

Eigen::VectorXd solveSymmetric(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  return Eigen::LDLT<Eigen::MatrixXd>(matrix).solve(right);
}

}  // namespace sphere_propagation
