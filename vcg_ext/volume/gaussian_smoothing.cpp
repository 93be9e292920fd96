// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/gaussian_smoothing.h"

#include <cmath>
#include <sstream>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

/// The sample that stands at position i of a line of n samples mirrored at both ends, edge samples
/// twice.
int mirrored(int i, int n) {
  const int period = 2 * n;
  i = ((i % period) + period) % period;
  return i < n ? i : period - 1 - i;
}

}  // namespace

void smoothGaussian(ScalarGrid& grid, double standardDeviation, double truncate) {
  if (!(standardDeviation >= 0) || !(truncate > 0) || !(standardDeviation * truncate <= 1e4)) {
    std::ostringstream text;
    text << "Smoothing: the standard deviation must be at least 0, the truncation above 0 and "
            "their product at most 10000, but they are "
         << standardDeviation << " and " << truncate << ".";
    throw ArgumentError(text.str());
  }
  if (standardDeviation == 0 || grid.values.empty()) return;
  const int radius = static_cast<int>(std::lround(truncate * standardDeviation));
  std::vector<double> kernel;
  double sum = 0;
  for (int x = -radius; x <= radius; ++x) {
    kernel.push_back(std::exp(-0.5 * x * x / (standardDeviation * standardDeviation)));
    sum += kernel.back();
  }
  for (double& weight : kernel) weight /= sum;

  size_t stride = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const int n = grid.size[axis];
    std::vector<double> line(static_cast<size_t>(n) + 2 * static_cast<size_t>(radius));
    for (size_t start = 0; start < grid.values.size(); ++start) {
      if ((start / stride) % static_cast<size_t>(n) != 0)
        continue;  // not the first sample of a line
      for (size_t i = 0; i < line.size(); ++i)
        line[i] = static_cast<double>(
            grid.values[start +
                        stride * static_cast<size_t>(mirrored(static_cast<int>(i) - radius, n))]);
      for (int i = 0; i < n; ++i) {
        double value = 0;
        for (size_t x = 0; x < kernel.size(); ++x)
          value += kernel[x] * line[static_cast<size_t>(i) + x];
        grid.values[start + stride * static_cast<size_t>(i)] = static_cast<float>(value);
      }
    }
    stride *= static_cast<size_t>(n);
  }
}

}  // namespace sphere_propagation
