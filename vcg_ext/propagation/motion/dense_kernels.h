// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The two products of dense matrices that fits of motion spend their time in, as fast as the
/// processor can.
///
/// Instructions are chosen at run time. Every entry is summed up in the same order, and no
/// multiplication is fused with an addition, so that results are the same bit for bit on every
/// processor.

#include <Eigen/Core>

namespace sphere_propagation {

/// The rows of a matrix lie side by side.
using RowsF = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The sum over rows r of r r^T: #C by #C for #R by #C rows.
Eigen::MatrixXf sumOfOuterProducts(const RowsF& rows);

/// The inverse of a symmetric positive definite matrix, of which the lower triangle is read.
Eigen::MatrixXd inverseOf(const Eigen::MatrixXd& positiveDefinite);

}  // namespace sphere_propagation
