// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/display/displacement_colors.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

constexpr std::array<std::array<double, 3>, 9> scale = {{{33, 102, 172},
                                                         {67, 147, 195},
                                                         {146, 197, 222},
                                                         {209, 229, 240},
                                                         {247, 247, 247},
                                                         {253, 219, 199},
                                                         {244, 165, 130},
                                                         {214, 96, 77},
                                                         {178, 24, 43}}};

}  // namespace

Eigen::VectorXd normalDisplacements(const Points& from, const Points& to, const Triangles& faces) {
  return (to - from).cwiseProduct(vertexNormals(from, faces)).rowwise().sum();
}

Colors displacementColors(const Eigen::VectorXd& values, double range) {
  Colors colors(values.size(), 3);
  for (Eigen::Index v = 0; v < values.size(); ++v) {
    double share =
        range > 0 && std::isfinite(values[v]) ? std::clamp(values[v] / range, -1.0, 1.0) : 0.0;
    share = (share + 1) / 2 * (scale.size() - 1);
    const auto below = std::min(static_cast<size_t>(share), scale.size() - 2);
    const double above = share - static_cast<double>(below);
    for (size_t k = 0; k < 3; ++k)
      colors(v, static_cast<Eigen::Index>(k)) = static_cast<unsigned char>(
          std::lround((1 - above) * scale.at(below).at(k) + above * scale.at(below + 1).at(k)));
  }
  return colors;
}

}  // namespace sphere_propagation
