// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/thin_svd.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "vcg_ext/base/eigen_system.h"

namespace sphere_propagation {
namespace {

using Dense = Eigen::MatrixXd;

/// Smallest eigenvalue that one Gram matrix is believed, as a share of its largest.
constexpr double believed = 1e-5;

constexpr Eigen::Index panel = 96;  // columns that one task works on: does not depend on threads

int panelsOf(Eigen::Index columns) { return static_cast<int>((columns + panel - 1) / panel); }

/// left right.
Dense product(const Dense& left, const Dense& right, ThreadPool& pool) {
  Dense result(left.rows(), right.cols());
  pool.forEach(panelsOf(right.cols()), [&](int p) {
    const Eigen::Index begin = p * panel, count = std::min(panel, right.cols() - begin);
    result.middleCols(begin, count).noalias() = left * right.middleCols(begin, count);
  });
  return result;
}

/// The lower triangle of matrix^T matrix, the upper one being 0 or the same.
Dense gram(const Dense& matrix, ThreadPool& pool) {
  Dense result = Dense::Zero(matrix.cols(), matrix.cols());
  pool.forEach(panelsOf(matrix.cols()), [&](int p) {
    const Eigen::Index begin = p * panel, count = std::min(panel, matrix.cols() - begin);
    const Eigen::Index below = matrix.cols() - begin;
    result.block(begin, begin, below, count).noalias() =
        matrix.rightCols(below).transpose() * matrix.middleCols(begin, count);
  });
  return result;
}

struct RightVectors {
  Eigen::VectorXd s;
  Dense v;
};

/// Of a matrix with no more columns than rows.
RightVectors rightVectors(const Dense& matrix, double rounding, ThreadPool& pool,
                          const Progress& progress) {
  const Eigen::Index size = matrix.cols();
  RightVectors found{Eigen::VectorXd(size), Dense(size, size)};
  Eigen::Index done = 0;
  Dense basis, rest;  // what is left: an orthonormal basis, and the matrix times it
  while (done < size) {
    const EigenSystem eigen = eigenSystemOf(gram(done == 0 ? matrix : rest, pool));
    const Eigen::Index columns = eigen.values.size();
    const double lowest = rounding * rounding, largest = eigen.values[columns - 1];
    if (!(largest > lowest)) break;
    Eigen::Index taken = 0;
    while (taken < columns &&
           eigen.values[columns - 1 - taken] > std::max(lowest, believed * largest)) {
      const double value = std::sqrt(eigen.values[columns - 1 - taken]);
      const Eigen::Index at = done + taken++;
      found.s[at] = at > 0 ? std::min(value, found.s[at - 1]) : value;
    }
    const Dense first = eigen.vectors.rightCols(taken).rowwise().reverse();
    found.v.middleCols(done, taken) = done == 0 ? first : product(basis, first, pool);
    const bool last = lowest >= believed * largest;
    if (!last && taken < columns) {
      const Dense others = eigen.vectors.leftCols(columns - taken);
      rest = product(done == 0 ? matrix : rest, others, pool);
      basis = done == 0 ? others : product(basis, others, pool);
    }
    done += taken;
    report(progress, static_cast<double>(done) / static_cast<double>(size));
    if (last) break;
  }
  found.s.conservativeResize(done);
  found.v.conservativeResize(Eigen::NoChange, done);
  return found;
}

/// Makes columns orthonormal one by one, each twice (W. Kahan: twice is enough).
void orthonormalise(Dense& u) {
  for (Eigen::Index j = 0; j < u.cols(); ++j) {
    for (int pass = 0; pass < 2; ++pass) {
      const Eigen::VectorXd along = u.leftCols(j).transpose() * u.col(j);
      u.col(j) -= u.leftCols(j) * along;
    }
    u.col(j).normalize();
  }
}

/// matrix v diag(1 / s) for the first columns, orthonormal to rounding. Those of small s carry what
/// rounding left of the large ones, which are accurate and so are taken away first.
Dense leftVectors(const Dense& matrix, const RightVectors& right, Eigen::Index count,
                  ThreadPool& pool) {
  const Dense scaled = right.v.leftCols(count) * right.s.head(count).cwiseInverse().asDiagonal();
  Dense u = product(matrix, scaled, pool);
  Dense step = gram(u, pool).transpose();
  step.triangularView<Eigen::StrictlyLower>().setZero();
  step.diagonal() = (step.diagonal().array() - 1) / 2;
  constexpr double nearly = 1e-7;  // one step of Gram and Schmidt, to first order, squares this
  if (count > 0 && step.cwiseAbs().maxCoeff() > nearly)
    orthonormalise(u);
  else
    u -= product(u, step, pool);
  return u;
}

}  // namespace

ThinSvd thinSvd(const Dense& matrix, double rounding, Eigen::Index count, ThreadPool& pool,
                const Progress& progress) {
  if (matrix.cols() <= matrix.rows()) {
    RightVectors right = rightVectors(matrix, rounding, pool, progress);
    count = std::min(count, right.s.size());
    Dense u = leftVectors(matrix, right, count, pool);
    return {std::move(u), std::move(right.s), std::move(right.v)};
  }
  const Dense transposed = matrix.transpose();
  RightVectors left = rightVectors(transposed, rounding, pool, progress);
  Dense v = leftVectors(transposed, left, left.s.size(), pool);
  return {left.v.leftCols(std::min(count, left.s.size())), std::move(left.s), std::move(v)};
}

}  // namespace sphere_propagation
