// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/slice_holes.h"

#include <algorithm>
#include <numeric>

namespace sphere_propagation {
namespace {

constexpr double minCover = 0.5, maxOpening = 0.1;

}  // namespace

SliceHoles::SliceHoles(const Mask& mask)
    : holes_(mask.size), filled_(mask), component_(mask.values.size(), -1) {
  const int nx = mask.size[0], ny = mask.size[1];
  const size_t plane = mask.index(0, 0, 1);
  std::vector<size_t> open;
  for (int k = 0; k < mask.size[2]; ++k) {
    std::vector<long> sizes;
    // The part of the outside with the slice's first voxel is no hole; what is found after it is
    // one each.
    constexpr int outside = -2;
    for (size_t start = plane * static_cast<size_t>(k);
         start < plane * (static_cast<size_t>(k) + 1); ++start) {
      if (mask.values[start] != 0 || component_[start] != -1) continue;
      const bool first = start == plane * static_cast<size_t>(k);
      const int number = first ? outside : static_cast<int>(sizes.size());
      long size = 0;
      open = {start};
      component_[start] = number;
      while (!open.empty()) {
        const size_t at = open.back();
        open.pop_back();
        ++size;
        const auto i = static_cast<int>(at % static_cast<size_t>(nx));
        const auto j = static_cast<int>(at / static_cast<size_t>(nx) % static_cast<size_t>(ny));
        const auto visit = [&](bool there, size_t next) {
          if (!there || mask.values[next] != 0 || component_[next] != -1) return;
          component_[next] = number;
          open.push_back(next);
        };
        visit(i > 0, at - 1);
        visit(i + 1 < nx, at + 1);
        visit(j > 0, at - static_cast<size_t>(nx));
        visit(j + 1 < ny, at + static_cast<size_t>(nx));
      }
      if (!first) sizes.push_back(size);
    }
    sizes_.push_back(std::move(sizes));
  }
  for (size_t v = 0; v < component_.size(); ++v) {
    component_[v] = std::max(component_[v], -1);
    if (component_[v] >= 0) holes_.values[v] = filled_.values[v] = 1;
  }
  for (auto slice = filled_.values.begin(); slice != filled_.values.end();
       slice += static_cast<std::ptrdiff_t>(plane))
    filledSizes_.push_back(
        std::count(slice, slice + static_cast<std::ptrdiff_t>(plane), std::uint8_t{1}));
}

bool SliceHoles::any() const {
  return std::any_of(sizes_.begin(), sizes_.end(),
                     [](const std::vector<long>& sizes) { return !sizes.empty(); });
}

/// The area of those holes of one slice that the other neither continues nor closes.
long SliceHoles::opened(int from, int to) const {
  const std::vector<long>& sizes = sizes_[static_cast<size_t>(from)];
  std::vector<long> covered(sizes.size(), 0);
  std::vector<char> continued(sizes.size(), 0);
  const size_t plane = filled_.index(0, 0, 1), a = plane * static_cast<size_t>(from),
               b = plane * static_cast<size_t>(to);
  for (size_t v = 0; v < plane; ++v) {
    if (component_[a + v] < 0) continue;
    const auto hole = static_cast<size_t>(component_[a + v]);
    if (holes_.values[b + v] != 0) continued[hole] = 1;
    covered[hole] += filled_.values[b + v];
  }
  long area = 0;
  for (size_t hole = 0; hole < sizes.size(); ++hole) {
    const auto least =
        static_cast<double>(std::min(sizes[hole], filledSizes_[static_cast<size_t>(to)]));
    const bool closed = covered[hole] > 0 && static_cast<double>(covered[hole]) >= minCover * least;
    if (continued[hole] == 0 && !closed) area += sizes[hole];
  }
  return area;
}

bool SliceHoles::leadThrough(int a, int b) const {
  long all = 0;
  for (const int slice : {a, b}) {
    const std::vector<long>& sizes = sizes_[static_cast<size_t>(slice)];
    all = std::accumulate(sizes.begin(), sizes.end(), all);
  }
  return all > 0 &&
         static_cast<double>(opened(a, b) + opened(b, a)) <= maxOpening * static_cast<double>(all);
}

}  // namespace sphere_propagation
