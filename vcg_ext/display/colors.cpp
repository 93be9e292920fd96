// SPDX-License-Identifier: GPL-3.0-only
// Hue to RGB: A. R. Smith, Color gamut transform pairs, 1978.

#include "vcg_ext/display/colors.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

constexpr std::array<std::array<double, 3>, 9> diverging = {{{33, 102, 172},
                                                             {67, 147, 195},
                                                             {146, 197, 222},
                                                             {209, 229, 240},
                                                             {247, 247, 247},
                                                             {253, 219, 199},
                                                             {244, 165, 130},
                                                             {214, 96, 77},
                                                             {178, 24, 43}}};

}  // namespace

Colors landmarkColors(Eigen::Index count) {
  Colors colors(count, 3);
  for (Eigen::Index j = 0; j < count; ++j) {
    const double hue =
        6 * static_cast<double>(j) / static_cast<double>(count);  // in sixths of the turn
    for (int k = 0; k < 3; ++k) {
      // Each channel is 1 for a sixth on both sides of its own hue (red 0, green 2, blue 4) and
      // falls to 0 over another.
      const double away = std::fabs(std::remainder(hue - 2 * k, 6.0));
      colors(j, k) = static_cast<unsigned char>(std::lround(255 * std::clamp(2 - away, 0.0, 1.0)));
    }
  }
  return colors;
}

Eigen::VectorXd normalDisplacements(const Points& from, const Points& to, const Triangles& faces) {
  return (to - from).cwiseProduct(vertexNormals(from, faces)).rowwise().sum();
}

Colors displacementColors(const Eigen::VectorXd& values, double range) {
  Colors colors(values.size(), 3);
  for (Eigen::Index v = 0; v < values.size(); ++v) {
    double share =
        range > 0 && std::isfinite(values[v]) ? std::clamp(values[v] / range, -1.0, 1.0) : 0.0;
    share = (share + 1) / 2 * (diverging.size() - 1);
    const auto below = std::min(static_cast<size_t>(share), diverging.size() - 2);
    const double above = share - static_cast<double>(below);
    for (size_t k = 0; k < 3; ++k)
      colors(v, static_cast<Eigen::Index>(k)) = static_cast<unsigned char>(std::lround(
          (1 - above) * diverging.at(below).at(k) + above * diverging.at(below + 1).at(k)));
  }
  return colors;
}

}  // namespace sphere_propagation
