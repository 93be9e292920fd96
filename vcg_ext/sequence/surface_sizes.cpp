// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/surface_sizes.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "vcg_ext/base/statistics.h"
#include "vcg_ext/base/unit_ratio.h"

namespace sphere_propagation {
namespace {

constexpr double kinds = 1.75, fromMedian = 2.2, deviations = 6;  // apart
constexpr double besideSeveral = 1.5, severalTimesUsual = 2.5;    // beside
constexpr double besideOne = 1.75, oneTimesUsual = 3.5;
constexpr double besideCalm = 1.25, calmTimesUsual = 4;  // several, along a sequence
constexpr size_t enoughSteps = 5;

std::vector<std::vector<int>> besideInTree(const PropagationTree& tree) {
  std::vector<std::vector<int>> beside = tree.children();
  for (int i = 0; i < tree.size(); ++i)
    if (const int parent = tree.parent[static_cast<size_t>(i)]; parent >= 0)
      beside[static_cast<size_t>(i)].push_back(parent);
  return beside;
}

/// The surfaces of another kind, by gaps and by the median.
std::vector<char> apartFromOthers(const std::vector<double>& sizes, int root) {
  const size_t count = sizes.size();
  std::vector<size_t> sorted(count);
  std::iota(sorted.begin(), sorted.end(), size_t{0});
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](size_t a, size_t b) { return sizes[a] < sizes[b]; });
  size_t first = 0, last = 0;  // of the largest kind
  for (size_t begin = 0, end = 0; begin < count; begin = end) {
    bool rootHere = false;
    do {
      rootHere = rootHere || static_cast<int>(sorted[end]) == root;
      ++end;
    } while (end < count && sizes[sorted[end]] - sizes[sorted[end - 1]] < std::log(kinds));
    if (end - begin < last - first || (end - begin == last - first && !rootHere)) continue;
    first = begin;
    last = end;
  }
  std::vector<double> within;
  for (size_t k = first; k < last; ++k) within.push_back(sizes[sorted[k]]);
  const RobustSpread usual = robustSpreadOf(std::move(within));
  const double most = std::max(std::log(fromMedian), deviations * usual.deviation);
  std::vector<char> apart(count, 1);
  for (size_t k = first; k < last; ++k)
    apart[sorted[k]] = std::fabs(sizes[sorted[k]] - usual.middle) > most ? 1 : 0;
  return apart;
}

/// Besides, the surfaces that are larger, or smaller, than all beside them; the one with most
/// beside it first, since those beside it then have one less.
void markUnlikeNeighbours(const std::vector<double>& sizes, const PropagationTree& tree,
                          std::vector<char>& odd) {
  const std::vector<std::vector<int>> beside = besideInTree(tree);
  const auto usualWithout = [&](int layer) {
    std::vector<double> steps;
    for (int i = 0; i < tree.size(); ++i) {
      const int parent = tree.parent[static_cast<size_t>(i)];
      if (parent < 0 || i == layer || parent == layer || odd[static_cast<size_t>(i)] ||
          odd[static_cast<size_t>(parent)])
        continue;
      steps.push_back(
          std::fabs(sizes[static_cast<size_t>(i)] - sizes[static_cast<size_t>(parent)]));
    }
    return std::pair(steps.empty() ? 0 : medianOf(steps), steps.size());
  };
  for (;;) {
    int worst = -1;
    size_t most = 0;
    double farthest = 0;
    for (int i = 0; i < tree.size(); ++i) {
      const auto k = static_cast<size_t>(i);
      if (odd[k]) continue;
      double least = HUGE_VAL;
      int larger = 0, smaller = 0;
      for (const int j : beside[k]) {
        if (odd[static_cast<size_t>(j)]) continue;
        const double step = sizes[k] - sizes[static_cast<size_t>(j)];
        least = std::min(least, std::fabs(step));
        ++(step > 0 ? larger : smaller);
      }
      const auto others = static_cast<size_t>(larger + smaller);
      if (others == 0 || (larger > 0 && smaller > 0)) continue;
      // Of two surfaces the root is right.
      if (others == 1 && i == tree.root() && tree.size() == 2) continue;
      const bool several = others > 1;
      if (least < std::log(besideCalm)) continue;
      const auto [usual, steps] = usualWithout(i);
      const bool leaps = least >= std::log(several ? besideSeveral : besideOne) &&
                         least >= (several ? severalTimesUsual : oneTimesUsual) * usual;
      const bool isBump = several && steps >= enoughSteps && least >= calmTimesUsual * usual;
      if (!leaps && !isBump) continue;
      if (others < most || (others == most && least <= farthest)) continue;
      worst = i;
      most = others;
      farthest = least;
    }
    if (worst < 0) return;
    odd[static_cast<size_t>(worst)] = 1;
  }
}

}  // namespace

double SurfaceSize::toOthers() const {
  if (!standsOut) return 1;
  if (units == 0) return 1 / relative;
  return relative > 1 ? 1 / units : units;
}

std::vector<SurfaceSize> findSurfaceSizes(const Sequence& sequence, const PropagationTree& tree) {
  std::vector<double> sizes;
  for (int i = 0; i < sequence.size(); ++i) sizes.push_back(std::log(sequence[i].radius()));
  std::vector<char> odd = apartFromOthers(sizes, tree.root());
  markUnlikeNeighbours(sizes, tree, odd);
  std::vector<double> right;
  for (size_t i = 0; i < sizes.size(); ++i)
    if (!odd[i]) right.push_back(sizes[i]);
  const double middle = right.empty() ? sizes[static_cast<size_t>(tree.root())] : medianOf(right);
  const std::vector<std::vector<int>> beside = besideInTree(tree);
  std::vector<SurfaceSize> result(sizes.size());
  for (size_t i = 0; i < sizes.size(); ++i) {
    double sum = 0;
    int count = 0;
    for (const int j : beside[i])
      if (!odd[static_cast<size_t>(j)]) {
        sum += sizes[static_cast<size_t>(j)];
        ++count;
      }
    result[i].relative = std::exp(sizes[i] - (count > 0 ? sum / count : middle));
    result[i].standsOut = odd[i] != 0;
    if (odd[i]) result[i].units = nearestUnitRatio(result[i].relative);
  }
  return result;
}

Sequence inRootsSize(const Sequence& sequence, const std::vector<SurfaceSize>& sizes,
                     const PropagationTree& tree) {
  const double ofRoot = sizes[static_cast<size_t>(tree.root())].toOthers();
  Sequence sized = sequence;
  for (const int i : tree.order) {
    const auto k = static_cast<size_t>(i);
    const double scale = sizes[k].toOthers() / ofRoot;
    if (scale == 1 || i == tree.root()) continue;
    const ClosedSurface& surface = sequence.surface(i);
    const Vector3 &centre = sequence[i].centre(), &parents = sized[tree.parent[k]].centre();
    const Vector3 fixed = (scale * centre - parents).norm() <= (centre - parents).norm()
                              ? Vector3(Vector3::Zero())
                              : centre;
    sized =
        sized.with(i, surface.withVertices(
                          ((surface.vertices().rowwise() - fixed.transpose()) * scale).rowwise() +
                          fixed.transpose()));
  }
  return sized;
}

}  // namespace sphere_propagation
