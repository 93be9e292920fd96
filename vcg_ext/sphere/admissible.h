// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The margin that whatever moves vertices over the sphere keeps from the end of validity.

namespace sphere_propagation {

/// What keeps a map away from being lost: a face must not vanish, nor an edge grow so long that it
/// has no direction.
struct Admissible {
  static constexpr double minSolidAngle =
      2e-14;  ///< twice what the certificate asks, whatever the rounding
  static constexpr double maxSolidAngle = 6.0;
  static constexpr double minCosine = -0.9;  ///< of the angle between the ends of an edge
};

}  // namespace sphere_propagation
