// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/surface_errors.h"

#include <cmath>

namespace sphere_propagation {
namespace {

constexpr double alikeNormals = 0.45, onePlaneInEdges = 0.5;

}  // namespace

Eigen::MatrixXd surfaceErrorFactor(const Points& points, const Points& normals, double edge) {
  const Eigen::Index count = points.rows();
  const Eigen::RowVector3d middle = points.colwise().mean();
  Eigen::Matrix<double, Eigen::Dynamic, 4> places(count, 4);
  places.leftCols<3>() = normals / alikeNormals;
  places.col(3) =
      normals.cwiseProduct(points.rowwise() - middle).rowwise().sum() / (onePlaneInEdges * edge);
  const Eigen::ArrayXd there = (normals.rowwise().squaredNorm().array() > 0.5).cast<double>();
  Eigen::ArrayXd rest = there;
  Eigen::MatrixXd factor(count, maxErrorColumns);
  int columns = 0;
  for (; columns < maxErrorColumns; ++columns) {
    Eigen::Index pivot = 0;
    const double largest = rest.maxCoeff(&pivot);
    if (!(largest > minErrorShare)) break;
    Eigen::VectorXd column =
        there *
        (-0.5 * (places.rowwise() - places.row(pivot)).rowwise().squaredNorm().array()).exp();
    column.noalias() -= factor.leftCols(columns) * factor.row(pivot).head(columns).transpose();
    factor.col(columns) = column / std::sqrt(largest);
    rest = (rest - factor.col(columns).array().square()).max(0.0);
  }
  return factor.leftCols(columns);
}

}  // namespace sphere_propagation
