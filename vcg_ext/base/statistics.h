// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Figures of samples that a few wild ones do not move.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace sphere_propagation {

/// The median absolute deviation times this is the standard deviation where samples are normal.
constexpr double normalDeviation = 1.4826;

/// The middle value, of an even number of samples the mean of the middle two; 0 of none.
inline double medianOf(std::vector<double> samples) {
  if (samples.empty()) return 0;
  const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
  std::nth_element(samples.begin(), middle, samples.end());
  if (samples.size() % 2 == 1) return *middle;
  return (*middle + *std::max_element(samples.begin(), middle)) / 2;
}

/// The sample below which this share of the others lies, of two the lower one. samples: at least
/// one; share: 0 to 1.
inline double lowerQuantileOf(std::vector<double> samples, double share) {
  const auto at = samples.begin() +
                  static_cast<std::ptrdiff_t>(share * static_cast<double>(samples.size() - 1));
  std::nth_element(samples.begin(), at, samples.end());
  return *at;
}

/// The same, linear between the two.
inline double quantileOf(std::vector<double> samples, double share) {
  const double rank = share * static_cast<double>(samples.size() - 1);
  const auto below = samples.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(samples.begin(), below, samples.end());
  const double above =
      below + 1 < samples.end() ? *std::min_element(below + 1, samples.end()) : *below;
  return *below + (rank - static_cast<double>(below - samples.begin())) * (above - *below);
}

struct RobustSpread {
  double middle = 0;     ///< the median
  double deviation = 0;  ///< the standard deviation, from the median absolute deviation
};

inline RobustSpread robustSpreadOf(std::vector<double> samples) {
  RobustSpread spread;
  spread.middle = medianOf(samples);
  for (double& sample : samples) sample = std::fabs(sample - spread.middle);
  spread.deviation = normalDeviation * medianOf(std::move(samples));
  return spread;
}

}  // namespace sphere_propagation
