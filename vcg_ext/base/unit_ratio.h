// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Sizes that differ as units of length do.

namespace sphere_propagation {

/// The ratio of two units that a ratio of sizes, or its inverse, is close to: 10 (mm and cm), 25.4
/// (mm and inches), 100 (cm and m) or 1000 (mm and m), within a factor of 1.5; 0: of none. ratio:
/// > 0.
inline double nearestUnitRatio(double ratio) {
  constexpr double near = 1.5;
  const double factor = ratio > 1 ? ratio : 1 / ratio;
  for (const double units : {10.0, 25.4, 100.0, 1000.0})
    if (factor < near * units && units < near * factor) return units;
  return 0;
}

}  // namespace sphere_propagation
