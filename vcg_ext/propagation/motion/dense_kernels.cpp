// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/dense_kernels.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstring>

#include "vcg_ext/propagation/motion/tiny_numbers.h"

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

using AddKernels = void (*)(const double* points, const double* centres, const double* vectors,
                            int count, double sharpness, double* sums);

constexpr int pointsAtOnce = 32;

/// pointsAtOnce points beside each other: x of all, y of all, z of all, and so are the sums. In the
/// exponential x = n ln 2 + r, |r| <= ln 2 / 2: 2^n times Taylor's polynomial of r.
template <int bytes>
inline __attribute__((always_inline)) void addKernels(const double* points, const double* centres,
                                                      const double* vectors, int count,
                                                      double sharpness, double* sums) {
  using Vector __attribute__((vector_size(bytes))) = double;
  using Whole __attribute__((vector_size(bytes))) = long long;
  constexpr int width = bytes / sizeof(double);
  constexpr double toTwo = 1.4426950408889634, high = 0.693145751953125,
                   low = 1.42860682030941723212e-6;  // of ln 2
  constexpr double rounder = 6755399441055744.0;     // 1.5 2^52: adding it rounds
  constexpr double factorials[]{1.0 / 479001600,
                                1.0 / 39916800,
                                1.0 / 3628800,
                                1.0 / 362880,
                                1.0 / 40320,
                                1.0 / 5040,
                                1.0 / 720,
                                1.0 / 120,
                                1.0 / 24,
                                1.0 / 6,
                                0.5,
                                1.0,
                                1.0};
  for (int begin = 0; begin < pointsAtOnce; begin += width) {
    Vector x, y, z, first = {}, second = {}, third = {};
    std::memcpy(&x, points + begin, bytes);
    std::memcpy(&y, points + pointsAtOnce + begin, bytes);
    std::memcpy(&z, points + 2 * pointsAtOnce + begin, bytes);
    for (int q = 0; q < count; ++q) {
      const double *c = centres + 3 * q, *v = vectors + 3 * q;
      const Vector power = (x * c[0] + y * c[1] + z * c[2] - 1.0) * sharpness;
      const Vector rounded = power * toTwo + rounder, n = rounded - rounder;
      const Vector r = (power - n * high) - n * low;
      Vector sum = r * factorials[0] + factorials[1];
      for (int k = 2; k < 13; ++k) sum = sum * r + factorials[k];
      Whole exponent;  // n is in the low bits of `rounded`
      std::memcpy(&exponent, &rounded, bytes);
      exponent = (exponent + 1023) << 52;
      Vector two;
      std::memcpy(&two, &exponent, bytes);
      const Vector kernel = sum * two;
      first += kernel * v[0];
      second += kernel * v[1];
      third += kernel * v[2];
    }
    std::memcpy(sums + begin, &first, bytes);
    std::memcpy(sums + pointsAtOnce + begin, &second, bytes);
    std::memcpy(sums + 2 * pointsAtOnce + begin, &third, bytes);
  }
}

void addKernelsAnywhere(const double* points, const double* centres, const double* vectors,
                        int count, double sharpness, double* sums) {
  addKernels<16>(points, centres, vectors, count, sharpness, sums);
}

#if defined(__x86_64__) && defined(__GNUC__)
__attribute__((target("avx2"))) void addKernelsAvx2(const double* points, const double* centres,
                                                    const double* vectors, int count,
                                                    double sharpness, double* sums) {
  addKernels<32>(points, centres, vectors, count, sharpness, sums);
}

__attribute__((target("avx512f"))) void addKernelsAvx512(const double* points,
                                                         const double* centres,
                                                         const double* vectors, int count,
                                                         double sharpness, double* sums) {
  addKernels<64>(points, centres, vectors, count, sharpness, sums);
}

AddKernels quickestKernels() {
  if (__builtin_cpu_supports("avx512f")) return addKernelsAvx512;
  if (__builtin_cpu_supports("avx2")) return addKernelsAvx2;
  return addKernelsAnywhere;
}

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
AddKernels quickestKernels() { return addKernelsAnywhere; }

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
  padded.leftCols(columns) = withoutTiny(rows);
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

Points kernelSums(const Points& points, const Points& centres, const Points& vectors,
                  double sharpness) {
  static const AddKernels add = quickestKernels();
  using Block = Eigen::Matrix<double, pointsAtOnce, 3>;  // column by column
  Points found(points.rows(), 3);
  for (Eigen::Index begin = 0; begin < points.rows(); begin += pointsAtOnce) {
    const Eigen::Index count = std::min<Eigen::Index>(pointsAtOnce, points.rows() - begin);
    Block here = Block::Zero(), sums;
    here.topRows(count) = points.middleRows(begin, count);
    add(here.data(), centres.data(), vectors.data(), static_cast<int>(centres.rows()), sharpness,
        sums.data());
    found.middleRows(begin, count) = sums.topRows(count);
  }
  return found;
}

}  // namespace sphere_propagation
