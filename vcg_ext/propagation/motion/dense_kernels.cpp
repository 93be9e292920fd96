// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/dense_kernels.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstring>

// One version per instruction set, chosen when the library is loaded; elsewhere whatever the
// compiler targets.
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__)
#define FOR_EACH_PROCESSOR __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define FOR_EACH_PROCESSOR
#endif

namespace sphere_propagation {
namespace {

constexpr int lane = 64;  // bytes of a row that are worked on at once
constexpr int tile =
    6;  // rows of the result that are worked on at once: what fits into sixteen registers
constexpr int rowsAtOnce = 64;  // of the factors: what stays in the cache

using FloatLane __attribute__((vector_size(lane))) = float;
using DoubleLane __attribute__((vector_size(lane))) = double;

/// The lower triangle of matrix += sum over k of x_k y_k^T, and right of it what shares a tile or a
/// lane. x, y: `count` rows; all rows are `stride` numbers apart, which fill whole lanes; size: of
/// the matrix, a multiple of `tile`.
template <class Lane, class Number>
inline __attribute__((always_inline)) void addProducts(const Number* x, const Number* y, int count,
                                                       int size, Eigen::Index stride,
                                                       Number* matrix) {
  constexpr int width = lane / sizeof(Number);
  for (int begin = 0; begin < count; begin += rowsAtOnce) {
    const int end = std::min(count, begin + rowsAtOnce);
    for (int i = 0; i < size; i += tile)
      for (int j = 0; j < i + tile; j += width) {
        Lane sum[tile];
        for (int a = 0; a < tile; ++a) std::memcpy(&sum[a], matrix + (i + a) * stride + j, lane);
        for (int k = begin; k < end; ++k) {
          Lane right;
          std::memcpy(&right, y + k * stride + j, lane);
          const Number* left = x + k * stride + i;
          for (int a = 0; a < tile; ++a) sum[a] += left[a] * right;
        }
        for (int a = 0; a < tile; ++a) std::memcpy(matrix + (i + a) * stride + j, &sum[a], lane);
      }
  }
}

FOR_EACH_PROCESSOR void addProducts(const float* x, const float* y, int count, int size,
                                    Eigen::Index stride, float* matrix) {
  addProducts<FloatLane>(x, y, count, size, stride, matrix);
}

FOR_EACH_PROCESSOR void addProducts(const double* x, const double* y, int count, int size,
                                    Eigen::Index stride, double* matrix) {
  addProducts<DoubleLane>(x, y, count, size, stride, matrix);
}

constexpr Eigen::Index roundedUp(Eigen::Index count, Eigen::Index to) {
  return (count + to - 1) / to * to;
}

}  // namespace

Eigen::MatrixXf sumOfOuterProducts(const RowsF& rows) {
  const Eigen::Index columns = rows.cols(), size = roundedUp(columns, tile),
                     stride = roundedUp(size, lane / Eigen::Index{sizeof(float)});
  RowsF padded = RowsF::Zero(rows.rows(), stride), sum = RowsF::Zero(size, stride);
  padded.leftCols(columns) = rows;
  addProducts(padded.data(), padded.data(), static_cast<int>(rows.rows()), static_cast<int>(size),
              stride, sum.data());
  return Eigen::MatrixXf(sum.topLeftCorner(columns, columns)).selfadjointView<Eigen::Lower>();
}

// Gauss-Jordan elimination of a few rows and columns at once, which keeps the matrix symmetric and
// ends in minus the inverse. Without a search for pivots: a positive definite matrix needs none.
Eigen::MatrixXd inverseOf(const Eigen::MatrixXd& positiveDefinite) {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  constexpr Eigen::Index block = 2 * tile;
  using Block = Eigen::Matrix<double, block, block>;
  const Eigen::Index count = positiveDefinite.rows(), size = roundedUp(count, block),
                     stride = roundedUp(size, lane / Eigen::Index{sizeof(double)});
  Rows matrix = Rows::Zero(size, stride);
  matrix.topLeftCorner(count, count) = positiveDefinite;
  matrix.diagonal().tail(size - count).setOnes();
  Rows solved = Rows::Zero(block, stride), minus = Rows::Zero(block, stride);
  for (Eigen::Index p = 0; p < size; p += block) {
    const Eigen::Index after = p + block, behind = size - after;
    const Block pivot = Block(matrix.block<block, block>(p, p)).selfadjointView<Eigen::Lower>();
    const Block inverse = pivot.llt().solve(Block::Identity());
    minus.leftCols(p) = -matrix.block(p, 0, block, p);
    minus.middleCols<block>(p).setZero();
    minus.middleCols(after, behind) = -matrix.block(after, p, behind, block).transpose();
    solved.leftCols(size).noalias() = -inverse * minus.leftCols(size);
    addProducts(solved.data(), minus.data(), block, static_cast<int>(size), stride, matrix.data());
    matrix.block(p, 0, block, p) = solved.leftCols(p);
    matrix.block<block, block>(p, p) = -inverse;
    matrix.block(after, p, behind, block) = solved.middleCols(after, behind).transpose();
  }
  return Eigen::MatrixXd(-matrix.topLeftCorner(count, count)).selfadjointView<Eigen::Lower>();
}

}  // namespace sphere_propagation
