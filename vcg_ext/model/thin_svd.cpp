// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/thin_svd.h"

#include <Eigen/SVD>

namespace sphere_propagation {

ThinSvd thinSvd(const Eigen::MatrixXd& matrix) {
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(matrix, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

}  // namespace sphere_propagation
