// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Eigenvalues of dense symmetric matrices of any size, compiled once: compilers take long for it.

#include <Eigen/Core>

namespace sphere_propagation {

/// matrix = vectors diag(values) vectors^T, values ascending, vectors orthonormal columns.
struct Spectrum {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

/// symmetric: its lower triangle is read.
Spectrum spectrumOf(const Eigen::MatrixXd& symmetric);

}  // namespace sphere_propagation
