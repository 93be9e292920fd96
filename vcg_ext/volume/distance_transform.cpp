// SPDX-License-Identifier: GPL-3.0-only
// P. F. Felzenszwalb, D. P. Huttenlocher, Distance transforms of sampled functions, 2012.

#include "vcg_ext/volume/distance_transform.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sphere_propagation {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

/// Replaces f(q) by the minimum over p of f(p) + (h (p - q))^2, along lines of one length.
class LineTransform {
 public:
  LineTransform(int length, double h)
      : n_(static_cast<size_t>(length)), h2_(h * h), line_(n_), apex_(n_), start_(n_ + 1) {}

  void operator()(float* first, size_t stride) {
    size_t parabolas = 0;
    for (size_t q = 0; q < n_; ++q) {
      line_[q] = static_cast<double>(first[q * stride]);
      if (line_[q] == std::numeric_limits<double>::infinity()) continue;
      double from = -std::numeric_limits<double>::infinity();
      while (parabolas > 0) {
        const size_t p = apex_[parabolas - 1];
        const auto x = static_cast<double>(q), y = static_cast<double>(p);
        from = ((line_[q] / h2_ + x * x) - (line_[p] / h2_ + y * y)) / (2 * (x - y));
        if (from > start_[parabolas - 1]) break;
        --parabolas;
        from = -std::numeric_limits<double>::infinity();
      }
      apex_[parabolas] = q;
      start_[parabolas++] = from;
    }
    if (parabolas == 0) return;
    size_t k = 0;
    for (size_t q = 0; q < n_; ++q) {
      while (k + 1 < parabolas && start_[k + 1] < static_cast<double>(q)) ++k;
      const double away = static_cast<double>(q) - static_cast<double>(apex_[k]);
      first[q * stride] = static_cast<float>(line_[apex_[k]] + h2_ * away * away);
    }
  }

 private:
  size_t n_;
  double h2_;
  std::vector<double> line_;
  std::vector<size_t> apex_;
  std::vector<double> start_;
};

/// Squared distance to the nearest voxel of the kind `feature`.
std::vector<float> squaredDistance(const Mask& mask, const Vector3& spacing, int dimensions,
                                   bool feature) {
  std::vector<float> distance(mask.values.size());
  for (size_t i = 0; i < distance.size(); ++i)
    distance[i] = (mask.values[i] != 0) == feature ? 0.0F : infinity;
  size_t stride = 1;
  for (int axis = 0; axis < dimensions; ++axis) {
    const auto n = static_cast<size_t>(mask.size[axis]);
    LineTransform transform(mask.size[axis], spacing[axis]);
    for (size_t block = 0; block < distance.size(); block += stride * n)
      for (size_t start = block; start < block + stride; ++start)
        transform(&distance[start], stride);
    stride *= n;
  }
  return distance;
}

}  // namespace

std::vector<float> signedDistance(const Mask& mask, const Vector3& spacing, int dimensions) {
  const auto half = static_cast<float>(spacing.head(dimensions).minCoeff() / 2);
  std::vector<float> toInside = squaredDistance(mask, spacing, dimensions, true);
  const std::vector<float> toOutside = squaredDistance(mask, spacing, dimensions, false);
  for (size_t i = 0; i < toInside.size(); ++i)
    toInside[i] =
        mask.values[i] != 0 ? std::sqrt(toOutside[i]) - half : half - std::sqrt(toInside[i]);
  return toInside;
}

}  // namespace sphere_propagation
