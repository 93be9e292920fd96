// SPDX-License-Identifier: GPL-3.0-only
// Hue to RGB: A. R. Smith, Color gamut transform pairs, 1978.

#include "vcg_ext/display/landmark_colors.h"

#include <algorithm>
#include <cmath>

namespace sphere_propagation {

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

}  // namespace sphere_propagation
