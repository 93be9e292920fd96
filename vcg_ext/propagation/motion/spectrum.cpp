// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/spectrum.h"

#include <Eigen/Eigenvalues>

namespace sphere_propagation {

Spectrum spectrumOf(const Eigen::MatrixXd& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace sphere_propagation
