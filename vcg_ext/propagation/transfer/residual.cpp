// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/transfer/residual.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace sphere_propagation {

Residual residualOf(std::vector<double> distances) {
  if (distances.empty()) return {};
  Residual result;
  result.mean = std::accumulate(distances.begin(), distances.end(), 0.0) /
                static_cast<double>(distances.size());
  const double rank = 0.95 * static_cast<double>(distances.size() - 1);
  const auto below = distances.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(distances.begin(), below, distances.end());
  const double above =
      below + 1 < distances.end() ? *std::min_element(below + 1, distances.end()) : *below;
  result.p95 = *below + (rank - static_cast<double>(below - distances.begin())) * (above - *below);
  return result;
}

}  // namespace sphere_propagation
