// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/morphing/side_of_arc.h"

#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>

namespace sphere_propagation {
namespace {

// Wide enough for products of three coordinates times 2^1127 each, and so without memory to
// allocate.
using WideInteger = boost::multiprecision::number<boost::multiprecision::cpp_int_backend<
    4096, 4096, boost::multiprecision::signed_magnitude, boost::multiprecision::unchecked, void>>;

/// x 2^1127: an integer for every double x; here |x| < 2.
WideInteger asInteger(double x) {
  int exponent = 0;
  const double mantissa = std::frexp(x, &exponent);  // x = mantissa 2^exponent, exponent >= -1073
  return WideInteger(static_cast<long long>(std::ldexp(mantissa, 53))) << (exponent - 53 + 1127);
}

int exactSide(const Vector3& p, const Vector3& q, const Vector3& x) {
  WideInteger det = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    det +=
        asInteger(p[i]) * (asInteger(q[j]) * asInteger(x[k]) - asInteger(q[k]) * asInteger(x[j]));
  }
  return det.sign();
}

}  // namespace

int sideOfArc(const Vector3& p, const Vector3& q, const Vector3& x) {
  double det = 0, permanent = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double one = q[j] * x[k], other = q[k] * x[j];
    det += p[i] * (one - other);
    permanent += std::fabs(p[i]) * (std::fabs(one) + std::fabs(other));
  }
  // Six roundings on any path: below 6 * 2^-53 / (1 - 6 * 2^-53) of the permanent; the second term
  // is for products that underflow.
  const double bound = 1e-15 * permanent + 1e-300;
  if (det > bound) return 1;
  if (det < -bound) return -1;
  return exactSide(p, q, x);
}

}  // namespace sphere_propagation
