// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_basis.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "vcg_ext/base/dense_cholesky.h"
#include "vcg_ext/base/linear_solvers.h"
#include "vcg_ext/propagation/motion/tiny_numbers.h"

namespace sphere_propagation {
namespace {

/// The six matrices of strain and three of rotation are orthonormal.
constexpr double half = 0.70710678118654752440;

// Of the kernel, lengths in R. The curl-free part follows cavities better, the divergence-free one
// walls; the Gaussian follows what neither allows, and is better on everything that the other two
// were not chosen on.
constexpr double gaussianShare = 0.5, gaussianLength = 0.35;
constexpr double curlFreeShare = 0.225, curlFreeLength = 0.5;
constexpr double divergenceFreeShare = 0.275, divergenceFreeLength = 0.4;

/// The covariance of the displacements of two nodes that lie r apart, r in R.
Eigen::Matrix3d kernel(const Vector3& r) {
  const Vector3 a = r / curlFreeLength, b = r / divergenceFreeLength;
  const double wg = gaussianShare * std::exp(-0.5 * (r / gaussianLength).squaredNorm());
  const double wa = curlFreeShare * std::exp(-0.5 * a.squaredNorm());
  const double wb = 0.5 * divergenceFreeShare * std::exp(-0.5 * b.squaredNorm());
  return (wg + wa + wb * (2 - b.squaredNorm())) * Eigen::Matrix3d::Identity() -
         wa * a * a.transpose() + wb * b * b.transpose();
}

/// L with L L^T close to the kernel of all nodes: pivoted Cholesky by blocks of a node's three
/// coordinates, so that the columns turn with the nodes. Next is the node with the largest
/// unexplained variance x area.
template <class Matrix>
Matrix kernelFactor(const Points& nodes, const Eigen::VectorXd& areas, double radius) {
  const Eigen::Index count = nodes.rows();
  Matrix factor = Matrix::Zero(3 * count, Matrix::ColsAtCompileTime);
  Eigen::VectorXd rest = Eigen::VectorXd::Constant(count, 3);
  Eigen::MatrixX3d block(3 * count, 3);
  for (int k = 0; k + 3 <= Matrix::ColsAtCompileTime; k += 3) {
    Eigen::Index pivot = 0;
    rest.cwiseProduct(areas).maxCoeff(&pivot);
    if (!(rest[pivot] > 1e-12)) break;  // everything is explained
    for (Eigen::Index i = 0; i < count; ++i)
      block.middleRows<3>(3 * i) = kernel((nodes.row(i) - nodes.row(pivot)).transpose() / radius);
    block.noalias() -= factor.leftCols(k) * factor.block(3 * pivot, 0, 3, k).transpose();
    const SymmetricEigen unexplained = eigenOf(block.middleRows<3>(3 * pivot));
    const double least = 1e-12 * unexplained.values.maxCoeff();
    const Vector3 inverseRoots = unexplained.values.unaryExpr(
        [least](double x) { return x > least ? 1 / std::sqrt(x) : 0.0; });
    const Eigen::Matrix3d& axes = unexplained.vectors;
    factor.template middleCols<3>(k).noalias() =
        block * (axes * inverseRoots.asDiagonal() * axes.transpose());
    for (Eigen::Index i = 0; i < count; ++i)
      rest[i] = std::max(rest[i] - factor.template block<3, 3>(3 * i, k).squaredNorm(), 0.0);
  }
  return factor;
}

/// A linear function of lengths in single precision. They are counted in a power of two of their
/// unit, which rounds nothing, so that no unit of length reaches the bounds of a float.
template <class Function>
Eigen::VectorXd inSingle(const Eigen::VectorXd& lengths, const Function& function) {
  int exponent = 0;
  std::frexp(lengths.size() > 0 ? lengths.lpNorm<Eigen::Infinity>() : 0.0, &exponent);
  const double unit = std::ldexp(1.0, exponent);
  const Eigen::VectorXf counted = (lengths / unit).cast<float>();
  const Eigen::VectorXf found = function(counted);
  return unit * found.cast<double>();
}

}  // namespace

MotionBasis::MotionBasis(const Points& nodes, const Eigen::VectorXd& areas, double radius)
    : local_(kernelFactor<decltype(local_)>(nodes, areas, radius)),
      single_(withoutTiny(local_.cast<float>())) {
  const Eigen::RowVector3d centre = (areas.transpose() * nodes) / areas.sum();
  arms_ = (nodes.rowwise() - centre) / radius;
}

void MotionBasis::project(int i, const Vector3& m, double* row) const {
  Eigen::Map<Eigen::Matrix<double, 1, localColumns>>(row).noalias() =
      m.transpose() * local_.middleRows<3>(3 * i);
  projectAffine(i, m, row + localColumns);
}

void MotionBasis::projectAffine(Eigen::Index i, const Vector3& m, double* row) const {
  const Vector3 y = arms_.row(i).transpose();
  for (int a = 0; a < 3; ++a) *row++ = m[a];
  for (int a = 0; a < 3; ++a) *row++ = m[a] * y[a];
  for (int a = 0; a < 2; ++a)
    for (int b = a + 1; b < 3; ++b) *row++ = half * (m[a] * y[b] + m[b] * y[a]);
  for (int a = 0; a < 2; ++a)
    for (int b = a + 1; b < 3; ++b) *row++ = half * (m[a] * y[b] - m[b] * y[a]);
}

Points MotionBasis::displacements(const Eigen::VectorXd& c) const {
  return withAffine(local_ * c.head<localColumns>(), c);
}

Points MotionBasis::roughDisplacements(const Eigen::VectorXd& c) const {
  return withAffine(inSingle(c.head<localColumns>(), [this](const auto& x) { return single_ * x; }),
                    c);
}

Points MotionBasis::withAffine(const Eigen::VectorXd& local, const Eigen::VectorXd& c) const {
  Points moved = Eigen::Map<const Points>(local.data(), arms_.rows(), 3);
  const double* a = c.data() + localColumns;
  Eigen::Matrix3d linear = Eigen::Vector3d(a[3], a[4], a[5]).asDiagonal();
  int k = 6;
  for (int i = 0; i < 2; ++i)
    for (int j = i + 1; j < 3; ++j, ++k) {
      linear(i, j) = half * (a[k] + a[k + 3]);
      linear(j, i) = half * (a[k] - a[k + 3]);
    }
  moved += arms_ * linear.transpose();
  moved.rowwise() += Eigen::RowVector3d(a[0], a[1], a[2]);
  return moved;
}

Eigen::MatrixXd MotionBasis::twists() const {
  constexpr int count = 5;
  std::array<Eigen::Matrix3d, count> symmetric;
  symmetric[0] = (half * Vector3(1, -1, 0)).asDiagonal();
  symmetric[1] = (Vector3(1, 1, -2) / std::sqrt(6.0)).asDiagonal();
  for (size_t k = 2; k < count; ++k) {
    const auto a = static_cast<Eigen::Index>(k - 2), b = (a + 1) % 3;
    symmetric[k].setZero();
    symmetric[k](a, b) = symmetric[k](b, a) = half;
  }
  Eigen::MatrixXd fields(local_.rows(), count);
  for (Eigen::Index i = 0; i < arms_.rows(); ++i) {
    const Vector3 y = arms_.row(i).transpose();
    for (size_t k = 0; k < count; ++k)
      fields.block<3, 1>(3 * i, static_cast<Eigen::Index>(k)) = y.cross(symmetric[k] * y);
  }
  Eigen::MatrixXd system = local_.transpose() * local_;
  system.diagonal().array() += 1e-4 * system.trace() / localColumns;
  return DenseCholesky(std::move(system)).solve(Eigen::MatrixXd(local_.transpose() * fields));
}

Eigen::VectorXd MotionBasis::projectAll(const Points& forces) const {
  const Eigen::Map<const Eigen::VectorXd> coordinates(forces.data(), forces.size());
  return withAffine(local_.transpose() * coordinates, forces);
}

Eigen::VectorXd MotionBasis::roughProjectAll(const Points& forces) const {
  const Eigen::Map<const Eigen::VectorXd> coordinates(forces.data(), forces.size());
  return withAffine(
      inSingle(coordinates, [this](const auto& x) { return single_.transpose() * x; }), forces);
}

Eigen::VectorXd MotionBasis::withAffine(const Eigen::VectorXd& local, const Points& forces) const {
  Eigen::VectorXd sum(columns);
  sum.head<localColumns>() = local;
  sum.segment<3>(localColumns) = forces.colwise().sum().transpose();
  const Eigen::Matrix3d moment = forces.transpose() * arms_;  // of f_a y_b
  int k = localColumns + 3;
  for (int a = 0; a < 3; ++a) sum[k++] = moment(a, a);
  for (int a = 0; a < 2; ++a)
    for (int b = a + 1; b < 3; ++b) sum[k++] = half * (moment(a, b) + moment(b, a));
  for (int a = 0; a < 2; ++a)
    for (int b = a + 1; b < 3; ++b) sum[k++] = half * (moment(a, b) - moment(b, a));
  return sum;
}

RowsF MotionBasis::roughRows(const Points& directions, const Eigen::VectorXd& weights) const {
  RowsF rows(directions.rows(), columns);
  Eigen::Matrix<double, affineColumns, 1> affine;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const Vector3 m = std::sqrt(weights[i]) * directions.row(i).transpose();
    const Eigen::Vector3f f = m.cast<float>();
    rows.row(i).head<localColumns>() =
        f[0] * single_.row(3 * i) + f[1] * single_.row(3 * i + 1) + f[2] * single_.row(3 * i + 2);
    projectAffine(i, m, affine.data());
    rows.row(i).tail<affineColumns>() = affine.cast<float>().transpose();
  }
  return rows;
}

Eigen::MatrixXd MotionBasis::roughInformation(const Points& directions,
                                              const Eigen::VectorXd& weights) const {
  return sumOfOuterProducts(roughRows(directions, weights)).cast<double>();
}

}  // namespace sphere_propagation
