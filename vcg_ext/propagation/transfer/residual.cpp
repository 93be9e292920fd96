// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/transfer/residual.h"

#include <numeric>
#include <utility>

#include "vcg_ext/base/statistics.h"

namespace sphere_propagation {

Residual residualOf(std::vector<double> distances) {
  if (distances.empty()) return {};
  Residual result;
  result.mean = std::accumulate(distances.begin(), distances.end(), 0.0) /
                static_cast<double>(distances.size());
  result.p95 = quantileOf(std::move(distances), 0.95);
  return result;
}

}  // namespace sphere_propagation
