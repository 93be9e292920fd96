// SPDX-License-Identifier: GPL-3.0-only
// The filtered checkerboard follows I. Quilez, "Filtering the checkerboard pattern", 2008: a square
// wave that is averaged over an interval is a difference of its antiderivative, which is a triangle
// wave. Red and blue are the ends of K. Moreland, Diverging color maps for scientific
// visualization, 2009.

#include "vcg_ext/display/sphere_pattern.h"

#include <algorithm>
#include <cmath>

#include "vcg_ext/base/error.h"
#include "vcg_ext/sphere/sphere_coordinates.h"

namespace sphere_propagation {
namespace {

using Color = Eigen::Array3d;  // red, green, blue in [0, 1]

/// Antiderivative of the square wave that is 1 on [0, 1), -1 on [1, 2), and so on.
double triangleWave(double x) { return 1 - std::fabs(x - 2 * std::floor(x / 2) - 1); }

/// The mean of the square wave over [x - h, x + h].
double squareWave(double x, double h) {
  if (h < 1e-6) return x - 2 * std::floor(x / 2) < 1 ? 1 : -1;
  return (triangleWave(x + h) - triangleWave(x - h)) / (2 * h);
}

/// How much of [x - h, x + h] lies within `half` of 0, in [0, 1]; far away from 0, nothing.
double covered(double x, double half, double h) {
  if (h < 1e-9) return std::fabs(x) <= half ? 1 : 0;
  return std::max(0.0, std::min(x + h, half) - std::max(x - h, -half)) / (2 * h);
}

/// The same where stripes are repeated at all whole numbers.
double coveredByStripes(double x, double half, double h) {
  if (h >= 0.5) return 2 * half;  // wider than the period: the mean
  const double away = x - std::round(x);
  return std::min(1.0,
                  covered(away, half, h) + covered(away - 1, half, h) + covered(away + 1, half, h));
}

/// longitude: in turns; latitude: in quarter turns.
Color directionColor(double longitude, double latitude, double amplitude) {
  Color hue;
  constexpr double turn[3] = {0.02, 0.36, 0.66};
  for (int k = 0; k < 3; ++k)
    hue[k] = 0.98 - amplitude + amplitude * std::cos(2 * pi * (longitude - turn[k]));
  const double pole = latitude > 0 ? 0.98 : 0.40;
  const double fading = std::fabs(latitude * latitude * latitude);
  return (1 - fading) * hue + fading * pole;
}

/// A point of the sphere, and over what its colour is averaged.
struct Spot {
  double longitude, colatitude;            // in turns, and in half turns
  double alongLongitude, alongColatitude;  // half widths of the average in the same units
};

Spot spotAt(const Vector3& position, double spacing) {
  const Vector2 uv = textureCoordinate(position);
  const double half = spacing / 2;
  const double radius =
      std::max(std::hypot(position.x(), position.y()), 1e-12);  // of the circle of latitude
  return {uv[0], uv[1], std::min(half / (2 * pi * radius), 1.0), half / pi};
}

Color checkerboard(const Spot& spot, const SpherePatternParameters& p) {
  const double light = squareWave(spot.longitude * p.around(), spot.alongLongitude * p.around()) *
                       squareWave(spot.colatitude * p.cells, spot.alongColatitude * p.cells);
  return directionColor(spot.longitude, 1 - 2 * spot.colatitude, 0.32) * (1 - 0.25 * (1 - light));
}

Color graticule(const Spot& spot, const SpherePatternParameters& p) {
  // In fields; stripes are at least as wide as the average, or they would look dashed.
  const double alongU = spot.alongLongitude * p.around(), alongV = spot.alongColatitude * p.cells;
  const double wideU = std::min(0.5, std::max(0.08, alongU)),
               wideV = std::min(0.5, std::max(0.08, alongV));
  // No parallel runs through the poles.
  const double v = std::clamp(spot.colatitude * p.cells, 1 - 0.5, p.cells - 0.5);
  const double meridian = coveredByStripes(spot.longitude * p.around(), wideU, alongU);
  const double parallel = coveredByStripes(v, wideV, alongV);
  const double zero = covered(std::remainder(spot.longitude, 1.0) * p.around(), wideU, alongU);
  const double equator = covered((spot.colatitude - 0.5) * p.cells, wideV, alongV);
  const Color line = 0.75 * directionColor(spot.longitude, 1 - 2 * spot.colatitude, 0.45);
  Color color = Color::Constant(0.96);
  color += (1 - (1 - meridian) * (1 - parallel)) * (line - color);
  color *= 1 - (1 - (1 - std::min(1.0, zero)) * (1 - std::min(1.0, equator)));
  return color;
}

void setColor(Colors& colors, Eigen::Index row, const Color& color) {
  for (int k = 0; k < 3; ++k)
    colors(row, k) = static_cast<unsigned char>(std::lround(255 * std::clamp(color[k], 0.0, 1.0)));
}

}  // namespace

int cellsFor(Eigen::Index vertices) {
  constexpr double perField = 36;
  const double cells = std::sqrt(static_cast<double>(std::max<Eigen::Index>(vertices, 0)) /
                                 (1.5 * perField));  // half as many again round the equator
  return 2 * std::clamp(static_cast<int>(std::lround(cells / 2)), 2, 8);
}

Eigen::VectorXd sphereSpacing(const Points& positions, const Triangles& faces) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(positions.rows()), count = sum;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, k), b = faces(f, (k + 1) % 3);
      const double chord = (positions.row(a) - positions.row(b)).norm();
      const double length = 2 * std::asin(std::min(1.0, chord / 2));
      for (const int v : {a, b}) {
        sum[v] += length;
        count[v] += 1;
      }
    }
  return sum.cwiseQuotient(count.cwiseMax(1));
}

Colors sphereColors(const Points& positions, const Eigen::VectorXd& spacing,
                    const SpherePatternParameters& parameters) {
  requireRange("number of cells", parameters.cells, Range::between(2, maxPatternCells));
  Colors colors(positions.rows(), 3);
  for (Eigen::Index i = 0; i < positions.rows(); ++i) {
    const Spot spot = spotAt(positions.row(i).transpose(), spacing[i]);
    switch (parameters.pattern) {
      case SpherePattern::Checkerboard:
        setColor(colors, i, checkerboard(spot, parameters));
        break;
      case SpherePattern::Graticule:
        setColor(colors, i, graticule(spot, parameters));
        break;
      case SpherePattern::Direction:
        setColor(colors, i, directionColor(spot.longitude, 1 - 2 * spot.colatitude, 0.45));
        break;
    }
  }
  return colors;
}

Colors areaRatioColors(const Eigen::VectorXd& ratios, double limit) {
  requireRange("area ratio at which colours end", limit, Range::above(1));
  const Color neutral(0.86, 0.86, 0.86), more(0.706, 0.016, 0.150), less(0.230, 0.299, 0.754);
  Colors colors(ratios.size(), 3);
  for (Eigen::Index i = 0; i < ratios.size(); ++i) {
    const double t = std::clamp(std::log(std::max(ratios[i], 1e-300)) / std::log(limit), -1.0, 1.0);
    const Color color = neutral + std::fabs(t) * ((t > 0 ? more : less) - neutral);
    setColor(colors, i, color);
  }
  return colors;
}

}  // namespace sphere_propagation
