// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/registration/principal_axes.h"

#include <Eigen/Geometry>

#include "vcg_ext/base/linear_solvers.h"

namespace sphere_propagation {

PrincipalAxes principalAxes(const Points& points) {
  PrincipalAxes result;
  result.centroid = points.colwise().mean().transpose();
  const Points centred = points.rowwise() - result.centroid.transpose();
  // Relative to the extent, so that squares neither overflow nor vanish.
  const double extent = centred.cwiseAbs().maxCoeff();
  if (!(extent > 0)) return result;
  const Points unit = centred / extent;
  const Eigen::Matrix3d covariance = unit.transpose() * unit / static_cast<double>(points.rows());
  const SymmetricEigen eigen = eigenOf(covariance);  // ascending
  result.axes.col(0) = eigen.vectors.col(2);
  result.axes.col(1) = eigen.vectors.col(1);
  result.axes.col(2) = result.axes.col(0).cross(result.axes.col(1));
  result.variances = extent * extent * eigen.values.reverse().cwiseMax(0);
  const Points along = centred * result.axes;
  result.ranges = (along.colwise().maxCoeff() - along.colwise().minCoeff()).transpose();
  return result;
}

Points scaledToExtents(const Points& points, const PrincipalAxes& reference) {
  constexpr double nothing =
      1e-9;  // of the largest range: what rounding leaves of a flat cloud's thickness
  const PrincipalAxes own = principalAxes(points);
  Vector3 factors = Vector3::Ones();
  for (int k = 0; k < 3; ++k)
    if (own.ranges[k] > nothing * own.ranges.maxCoeff() &&
        reference.ranges[k] > nothing * reference.ranges.maxCoeff())
      factors[k] = reference.ranges[k] / own.ranges[k];
  const Eigen::Matrix3d scaling =
      own.axes * factors.asDiagonal() * own.axes.transpose();  // symmetric
  return ((points.rowwise() - own.centroid.transpose()) * scaling).rowwise() +
         reference.centroid.transpose();
}

}  // namespace sphere_propagation
