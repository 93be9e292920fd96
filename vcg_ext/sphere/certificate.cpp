// SPDX-License-Identifier: GPL-3.0-only
// Orientation of a spherical triangle: the sign of det(a, b, c), decided by a floating-point filter
// in the manner of J. R. Shewchuk, Adaptive precision floating-point arithmetic and fast robust
// geometric predicates, 1997, and by wide integers (Boost.Multiprecision) where the filter cannot
// tell.
//
// Solid angle: A. van Oosterom and J. Strackee, The solid angle of a plane triangle, 1983.

#include "vcg_ext/sphere/certificate.h"

#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>
#include <sstream>

namespace sphere_propagation {
namespace {

// Wide enough for products of three coordinates times 2^1127 each, and so without memory to
// allocate.
using Integer = boost::multiprecision::number<boost::multiprecision::cpp_int_backend<
    4096, 4096, boost::multiprecision::signed_magnitude, boost::multiprecision::unchecked, void>>;

/// x 2^1127: an integer for every double x; here |x| <= 1 + unitTolerance.
Integer scaled(double x) {
  int exponent = 0;
  const double mantissa = std::frexp(x, &exponent);  // x = mantissa 2^exponent, exponent >= -1073
  return Integer(static_cast<long long>(std::ldexp(mantissa, 53))) << (exponent - 53 + 1127);
}

int exactSign(const double* a, const double* b, const double* c) {
  const Integer bx = scaled(b[0]), by = scaled(b[1]), bz = scaled(b[2]);
  const Integer cx = scaled(c[0]), cy = scaled(c[1]), cz = scaled(c[2]);
  const Integer det = scaled(a[0]) * (by * cz - bz * cy) + scaled(a[1]) * (bz * cx - bx * cz) +
                      scaled(a[2]) * (bx * cy - by * cx);
  return det.sign();
}

/// Sign of det(a, b, c), and its value in floating point.
int orientation(const double* a, const double* b, const double* c, double& det) {
  const double x1 = b[1] * c[2], x2 = b[2] * c[1], y1 = b[2] * c[0], y2 = b[0] * c[2],
               z1 = b[0] * c[1], z2 = b[1] * c[0];
  det = a[0] * (x1 - x2) + a[1] * (y1 - y2) + a[2] * (z1 - z2);
  const double permanent = std::fabs(a[0]) * (std::fabs(x1) + std::fabs(x2)) +
                           std::fabs(a[1]) * (std::fabs(y1) + std::fabs(y2)) +
                           std::fabs(a[2]) * (std::fabs(z1) + std::fabs(z2));
  // Six roundings on any path: the error is below 6 * 2^-53 / (1 - 6 * 2^-53) of the permanent; the
  // second term is for products that underflow.
  const double bound = 1e-15 * permanent + 1e-300;
  if (det > bound) return 1;
  if (det < -bound) return -1;
  return exactSign(a, b, c);
}

double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

bool onSphere(const double* p) {
  const double length = std::sqrt(dot(p, p));
  return std::fabs(length - 1) <= Certificate::unitTolerance;  // false for NaN and infinity
}

}  // namespace

bool Certificate::valid() const {
  return notOnSphere == 0 && flippedFaces == 0 && std::fabs(degree - 1) < 1e-3;
}

std::string Certificate::reason() const {
  std::ostringstream text;
  if (notOnSphere > 0)
    text << notOnSphere << (notOnSphere == 1 ? " vertex does" : " vertices do")
         << " not lie on the unit sphere, the first is vertex " << firstNotOnSphere;
  else if (flippedFaces > 0)
    text << flippedFaces << (flippedFaces == 1 ? " face is" : " faces are")
         << " flipped on the sphere, the first is face " << firstFlippedFace;
  else if (!valid())
    text << "it covers the sphere " << std::lround(degree) << " times instead of once";
  return text.str();
}

Certificate certify(const Triangles& faces, const Points& positions) {
  Certificate result;
  for (Eigen::Index v = 0; v < positions.rows(); ++v)
    if (!onSphere(positions.row(v).data()) && result.notOnSphere++ == 0)
      result.firstNotOnSphere = v;
  double sum = 0;
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const double *a = positions.row(faces(f, 0)).data(), *b = positions.row(faces(f, 1)).data(),
                 *c = positions.row(faces(f, 2)).data();
    bool positive = onSphere(a) && onSphere(b) && onSphere(c);
    if (positive) {
      double det = 0;
      const int sign = orientation(a, b, c, det);
      positive = sign > 0;
      // The determinant from differences: det(a, b, c) = det(a, b - a, c - a), without the
      // cancellation for small faces.
      const double e[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]},
                   g[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
      det = a[0] * (e[1] * g[2] - e[2] * g[1]) + a[1] * (e[2] * g[0] - e[0] * g[2]) +
            a[2] * (e[0] * g[1] - e[1] * g[0]);
      // Where rounding gets its sign wrong, the exact one decides: between a hemisphere and its
      // complement, for example.
      if ((det > 0) - (det < 0) != sign) det = sign * std::numeric_limits<double>::denorm_min();
      const double solidAngle = 2 * std::atan2(det, 1 + dot(a, b) + dot(b, c) + dot(c, a));
      sum += solidAngle;
      positive = positive && solidAngle >= Certificate::minSolidAngle;
    }
    if (!positive && result.flippedFaces++ == 0) result.firstFlippedFace = f;
  }
  result.degree = sum / (4 * 3.14159265358979323846);
  return result;
}

}  // namespace sphere_propagation
