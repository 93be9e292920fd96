// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/groupwise/sphere_fields.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/sphere/spherical_triangle.h"

namespace sphere_propagation {
namespace {

constexpr double longestStep = 0.25;  // widths
constexpr double ridge = 1e-6;        // of the Gram matrix

/// Along the great circle that leaves x (a unit vector) with this velocity.
Vector3 alongGeodesic(const Vector3& x, const Vector3& velocity) {
  const double length = velocity.norm();
  if (!(length > 0)) return x;
  return (std::cos(length) * x + std::sin(length) / length * velocity).normalized();
}

}  // namespace

SphereFields::SphereFields(int frequency, double width) : width_(width) {
  requireRange("width of the fields", width, Range::above(0));
  centres_ = icosphere(frequency).vertices;
  tangents_.resize(2 * centres_.rows(), 3);
  for (Eigen::Index q = 0; q < centres_.rows(); ++q) {
    Vector3 s, t;
    tangentFrame(centres_.row(q).transpose(), s, t);
    tangents_.row(2 * q) = s.transpose();
    tangents_.row(2 * q + 1) = t.transpose();
  }
  Eigen::MatrixXd gram = tangents_ * tangents_.transpose();
  const Eigen::MatrixXd kernel = kernels(centres_);
  for (Eigen::Index j = 0; j < gram.cols(); ++j)
    for (Eigen::Index i = 0; i < gram.rows(); ++i) gram(i, j) *= kernel(i / 2, j / 2);
  gram.diagonal().array() += ridge;
  gram_ = gram.cast<float>();
}

Eigen::MatrixXd SphereFields::kernels(const Points& points) const {
  const double scale = 1 / (width_ * width_);
  return ((points * centres_.transpose()).array() * scale - scale).exp();
}

Points SphereFields::at(const Points& points, const Eigen::VectorXd& theta) const {
  Points vectors(centres_.rows(), 3);
  for (Eigen::Index q = 0; q < vectors.rows(); ++q)
    vectors.row(q) =
        theta[2 * q] * tangents_.row(2 * q) + theta[2 * q + 1] * tangents_.row(2 * q + 1);
  Points field = kernelSums(points, centres_, vectors, 1 / (width_ * width_));
  for (Eigen::Index i = 0; i < field.rows(); ++i)
    field.row(i) -= field.row(i).dot(points.row(i)) * points.row(i);
  return field;
}

RowsF SphereFields::rows(const Points& points, const Points& functionals) const {
  const Eigen::MatrixXf kernel = kernels(points).cast<float>();
  Points tangential(functionals.rows(), 3);
  for (Eigen::Index i = 0; i < functionals.rows(); ++i) {
    const auto u = points.row(i / 2);
    tangential.row(i) = functionals.row(i) - functionals.row(i).dot(u) * u;
  }
  RowsF result = tangential.cast<float>() * tangents_.cast<float>().transpose();
  for (Eigen::Index i = 0; i < result.rows(); ++i)
    for (Eigen::Index q = 0; q < kernel.cols(); ++q) {
      result(i, 2 * q) *= kernel(i / 2, q);
      result(i, 2 * q + 1) *= kernel(i / 2, q);
    }
  return result;
}

Points SphereFields::flow(const Points& points, const Eigen::VectorXd& theta, double time) const {
  Points here = points, field = at(here, theta);
  const double fastest =
      points.rows() > 0 ? std::fabs(time) * field.rowwise().norm().maxCoeff() : 0;
  if (!(fastest > 0)) return here;
  const int steps = std::max(1, static_cast<int>(std::ceil(fastest / (longestStep * width_))));
  const double step = time / steps;
  Points middle(here.rows(), 3);
  for (int i = 0; i < steps; ++i) {
    if (i > 0) field = at(here, theta);
    for (Eigen::Index p = 0; p < here.rows(); ++p)
      middle.row(p) =
          alongGeodesic(here.row(p).transpose(), step / 2 * field.row(p).transpose()).transpose();
    field = at(middle, theta);
    for (Eigen::Index p = 0; p < here.rows(); ++p) {
      // The velocity at the middle, carried back along the way: what leads from x through there.
      const Vector3 x = here.row(p).transpose(), m = middle.row(p).transpose();
      const Vector3 v = field.row(p).transpose(), along = v - v.dot(x) / (1 + x.dot(m)) * (x + m);
      here.row(p) = alongGeodesic(x, step * along).transpose();
    }
  }
  return here;
}

}  // namespace sphere_propagation
