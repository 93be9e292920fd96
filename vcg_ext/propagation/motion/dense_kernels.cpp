// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/dense_kernels.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstring>

namespace sphere_propagation {
namespace {

constexpr int tile = 6;  // rows of the result that are worked on at once, by two vectors: what fits
                         // into sixteen registers
constexpr int rowsAtOnce = 64;      // of the factors: what stays in the cache
constexpr Eigen::Index line = 128;  // bytes that all pairs of vectors divide

template <class Number>
using AddProducts = void (*)(const Number* x, const Number* y, int count, int size,
                             Eigen::Index stride, Number* matrix);

/// The lower triangle of matrix += sum over k of x_k y_k^T, and right of it what shares a tile or a
/// pair of vectors. x, y: `count` rows; all rows are `stride` numbers apart, which fill whole
/// lines; size: of the matrix, a multiple of `tile`. The vectors have to be those of the processor:
/// compilers take larger ones apart badly.
template <int bytes, class Number>
inline __attribute__((always_inline)) void addProducts(const Number* x, const Number* y, int count,
                                                       int size, Eigen::Index stride,
                                                       Number* matrix) {
  using Vector __attribute__((vector_size(bytes))) = Number;
  constexpr int width = bytes / sizeof(Number);
  for (int begin = 0; begin < count; begin += rowsAtOnce) {
    const int end = std::min(count, begin + rowsAtOnce);
    for (int i = 0; i < size; i += tile)
      for (int j = 0; j < i + tile; j += 2 * width) {
        Vector left[tile], right[tile];
        for (int a = 0; a < tile; ++a) {
          std::memcpy(&left[a], matrix + (i + a) * stride + j, bytes);
          std::memcpy(&right[a], matrix + (i + a) * stride + j + width, bytes);
        }
        for (int k = begin; k < end; ++k) {
          Vector first, second;
          std::memcpy(&first, y + k * stride + j, bytes);
          std::memcpy(&second, y + k * stride + j + width, bytes);
          for (int a = 0; a < tile; ++a) {
            const Number factor = x[k * stride + i + a];
            left[a] += factor * first;
            right[a] += factor * second;
          }
        }
        for (int a = 0; a < tile; ++a) {
          std::memcpy(matrix + (i + a) * stride + j, &left[a], bytes);
          std::memcpy(matrix + (i + a) * stride + j + width, &right[a], bytes);
        }
      }
  }
}

/// What every processor can.
template <class Number>
void addProductsAnywhere(const Number* x, const Number* y, int count, int size, Eigen::Index stride,
                         Number* matrix) {
  addProducts<16>(x, y, count, size, stride, matrix);
}

#if defined(__x86_64__) && defined(__GNUC__)
template <class Number>
__attribute__((target("avx2"))) void addProductsAvx2(const Number* x, const Number* y, int count,
                                                     int size, Eigen::Index stride,
                                                     Number* matrix) {
  addProducts<32>(x, y, count, size, stride, matrix);
}

template <class Number>
__attribute__((target("avx512f"))) void addProductsAvx512(const Number* x, const Number* y,
                                                          int count, int size, Eigen::Index stride,
                                                          Number* matrix) {
  addProducts<64>(x, y, count, size, stride, matrix);
}

template <class Number>
AddProducts<Number> quickest() {
  if (__builtin_cpu_supports("avx512f")) return addProductsAvx512<Number>;
  if (__builtin_cpu_supports("avx2")) return addProductsAvx2<Number>;
  return addProductsAnywhere<Number>;
}
#else
template <class Number>
AddProducts<Number> quickest() {
  return addProductsAnywhere<Number>;
}
#endif

template <class Number>
void addProducts(const Number* x, const Number* y, int count, int size, Eigen::Index stride,
                 Number* matrix) {
  static const AddProducts<Number> add = quickest<Number>();
  add(x, y, count, size, stride, matrix);
}

constexpr Eigen::Index roundedUp(Eigen::Index count, Eigen::Index to) {
  return (count + to - 1) / to * to;
}

}  // namespace

Eigen::MatrixXf sumOfOuterProducts(const RowsF& rows) {
  const Eigen::Index columns = rows.cols(), size = roundedUp(columns, tile),
                     stride = roundedUp(size, line / Eigen::Index{sizeof(float)});
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
                     stride = roundedUp(size, line / Eigen::Index{sizeof(double)});
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
