// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The products of dense matrices that fits of motion, and flows of the sphere, spend their time
/// in, as fast as the processor can.
///
/// Instructions are chosen at run time. Every entry is summed up in the same order, and no
/// multiplication is fused with an addition, so that results are the same bit for bit on every
/// processor.

#include <Eigen/Core>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// The rows of a matrix lie side by side.
using RowsF = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The sum over rows r of r r^T: #C by #C for #R by #C rows.
Eigen::MatrixXf sumOfOuterProducts(const RowsF& rows);

/// The inverse of a symmetric positive definite matrix, of which the lower triangle is read.
Eigen::MatrixXd inverseOf(const Eigen::MatrixXd& positiveDefinite);

/// Row i: sum over q of exp(sharpness (u_i . c_q - 1)) v_q, for unit vectors u_i (points, #P by 3)
/// and c_q (centres, #Q by 3), v_q the rows of `vectors` (#Q by 3). sharpness: 0 .. 350. The
/// exponential is right to 4e-16 of its value.
Points kernelSums(const Points& points, const Points& centres, const Points& vectors,
                  double sharpness);

}  // namespace sphere_propagation
