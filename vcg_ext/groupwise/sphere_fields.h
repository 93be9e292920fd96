// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Smooth vector fields on the sphere and their flows, by which maps are moved along surfaces.

#include <Eigen/Core>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/propagation/motion/dense_kernels.h"

namespace sphere_propagation {

/// Fields v(u) = P_u sum over q of k(u, q) (a_q s_q + b_q t_q) on the unit sphere: q are the
/// vertices of an icosphere, s_q and t_q an orthonormal frame of the tangent plane there, P_u the
/// projection to the tangent plane at u, and k(u, q) = exp((u . q - 1) / width^2), close to a
/// Gaussian of this standard deviation (radian).
///
/// A field is given by its coefficients theta = (a_1, b_1, a_2, ...). Several threads may share one
/// object.
class SphereFields {
 public:
  /// frequency: of the icosphere, 1 or more; width: radian, above 0.
  SphereFields(int frequency, double width);

  /// Coefficients of a field, 2 (10 frequency^2 + 2).
  Eigen::Index count() const { return tangents_.rows(); }
  double width() const { return width_; }

  /// The field at these points (#P by 3 unit vectors), #P by 3.
  Points at(const Points& points, const Eigen::VectorXd& theta) const;

  /// Rows that give a linear function of the field at each point: entry (2 i + a) of rows theta is
  /// m . v(u_i), m = row 2 i + a of `functionals` (2 #P by 3). In single precision.
  RowsF rows(const Points& points, const Points& functionals) const;

  /// Where the points are after this time in the flow of the field: exp(time v). By geodesic steps
  /// of second order (midpoints), none longer than a quarter of the width. With -time they come
  /// back, but for the third power of that.
  Points flow(const Points& points, const Eigen::VectorXd& theta, double time = 1) const;

  /// theta^T gram theta is the square of the field's norm, which punishes what the kernel calls
  /// unlikely.
  const Eigen::MatrixXf& gram() const { return gram_; }

 private:
  Eigen::MatrixXd kernels(const Points& points) const;

  double width_;
  Points centres_;   // #Q by 3
  Points tangents_;  // 2 #Q by 3
  Eigen::MatrixXf gram_;
};

}  // namespace sphere_propagation
