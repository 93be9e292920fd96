// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// How far two surfaces are apart after one was moved onto the other, in two figures.

#include <vector>

namespace sphere_propagation {

struct Residual {
  double mean = 0;
  double p95 = 0;  ///< 95th percentile, linear between the two nearest ranks
};

/// distances: any number, in any order; all zero when there are none.
Residual residualOf(std::vector<double> distances);

}  // namespace sphere_propagation
