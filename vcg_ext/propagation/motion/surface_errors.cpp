// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/surface_errors.h"

#include <cmath>

#include "vcg_ext/propagation/motion/tiny_numbers.h"

namespace sphere_propagation {
namespace {

constexpr double alikeNormals = 0.45, onePlaneInEdges = 0.5;

}  // namespace

// In single precision: the factor is a model of errors, known to no more than a digit.
Eigen::MatrixXd surfaceErrorFactor(const Points& points, const Points& normals, double edge) {
  const Eigen::Index count = points.rows();
  const Eigen::RowVector3d middle = points.colwise().mean();
  Eigen::Matrix<float, Eigen::Dynamic, 4> places(count, 4);
  places.leftCols<3>() = (normals / alikeNormals).cast<float>();
  places.col(3) =
      (normals.cwiseProduct(points.rowwise() - middle).rowwise().sum() / (onePlaneInEdges * edge))
          .cast<float>();
  const Eigen::ArrayXf there = (normals.rowwise().squaredNorm().array() > 0.5).cast<float>();
  Eigen::ArrayXf rest = there;
  Eigen::MatrixXf factor(count, maxErrorColumns);
  int columns = 0;
  for (; columns < maxErrorColumns; ++columns) {
    Eigen::Index pivot = 0;
    const float largest = rest.maxCoeff(&pivot);
    if (!(largest > static_cast<float>(minErrorShare))) break;
    const Eigen::ArrayXf apart = (places.rowwise() - places.row(pivot)).rowwise().squaredNorm();
    Eigen::VectorXf column = there * (-0.5F * apart).exp();
    column.noalias() -= factor.leftCols(columns) * factor.row(pivot).head(columns).transpose();
    factor.col(columns) = withoutTiny(column / std::sqrt(largest));
    rest = (rest - factor.col(columns).array().square()).max(0.0F);
  }
  return factor.leftCols(columns).cast<double>();
}

}  // namespace sphere_propagation
