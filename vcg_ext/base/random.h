// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Random numbers that are the same on every machine: the distributions of <random> differ between
/// standard libraries, its generators do not.

#include <array>
#include <cmath>
#include <random>

namespace sphere_propagation {

/// Uniform in [0, 1), a multiple of 2^-53. As numpy's random_sample: from two words of 32 bits.
inline double uniformNumber(std::mt19937& bits) {
  const auto high = bits() >> 5, low = bits() >> 6;
  return (static_cast<double>(high) * 67108864.0 + static_cast<double>(low)) / 9007199254740992.0;
}

/// The same from one word of 64 bits.
inline double uniformNumber(std::mt19937_64& bits) {
  return static_cast<double>(bits() >> 11) * 0x1p-53;
}

/// Two independent standard normal numbers: G. Marsaglia's polar method.
template <class Generator>
std::array<double, 2> normalNumbers(Generator& bits) {
  for (;;) {
    const double x = 2 * uniformNumber(bits) - 1, y = 2 * uniformNumber(bits) - 1;
    const double square = x * x + y * y;
    if (square == 0 || square >= 1) continue;
    const double factor = std::sqrt(-2 * std::log(square) / square);
    return {factor * x, factor * y};
  }
}

}  // namespace sphere_propagation
