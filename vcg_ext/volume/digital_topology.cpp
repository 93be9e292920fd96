// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/digital_topology.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <set>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/volume/simple_point.h"

namespace sphere_propagation {
namespace {

/// Steps in the list of voxels to the neighbours of one that is not on the border.
class Steps {
 public:
  explicit Steps(const Mask& mask) {
    const std::ptrdiff_t row = mask.size[0], slice = row * mask.size[1];
    for (int n = 0; n < 27; ++n) {
      const int x = n % 3 - 1, y = n / 3 % 3 - 1, z = n / 9 - 1, d = x * x + y * y + z * z;
      to_[static_cast<size_t>(n)] = x + y * row + z * slice;
      if (d > 0) around_.push_back(to_[static_cast<size_t>(n)]);
      if (d == 1) faces_.push_back(to_[static_cast<size_t>(n)]);
      if (d == 1 || d == 2) facesAndEdges_.push_back(to_[static_cast<size_t>(n)]);
    }
  }
  const std::vector<std::ptrdiff_t>& faces() const { return faces_; }                  ///< 6
  const std::vector<std::ptrdiff_t>& facesAndEdges() const { return facesAndEdges_; }  ///< 18
  const std::vector<std::ptrdiff_t>& around() const { return around_; }                ///< 26

  Neighbourhood neighbourhood(const Mask& mask, size_t i) const {
    Neighbourhood bits = 0;
    const std::uint8_t* here = mask.values.data() + i;
    for (size_t n = 0; n < 27; ++n) bits |= static_cast<Neighbourhood>(here[to_[n]]) << n;
    return bits;
  }

 private:
  std::array<std::ptrdiff_t, 27> to_{};
  std::vector<std::ptrdiff_t> faces_, facesAndEdges_, around_;
};

size_t stepped(size_t i, std::ptrdiff_t step) {
  return static_cast<size_t>(static_cast<std::ptrdiff_t>(i) + step);
}

/// Calls visit(index) for the voxels of the grid's border.
template <class Visit>
void forBorder(const Mask& mask, const Visit& visit) {
  const Eigen::Vector3i n = mask.size;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j) {
      const bool all = k == 0 || j == 0 || k == n[2] - 1 || j == n[1] - 1;
      for (int i = 0; i < n[0]; i += all || n[0] == 1 ? 1 : n[0] - 1) visit(mask.index(i, j, k));
    }
}

void requireFreeBorder(const Mask& mask) {
  bool good = mask.size.minCoeff() > 0 && mask.values.size() == mask.voxelCount();
  if (good) forBorder(mask, [&](size_t i) { good = good && mask.values[i] == 0; });
  if (!good)
    throw ArgumentError("Topology of a mask: its border must be outside, and it must have voxels.");
}

/// The parts of the inside: the voxels of each, in the order of their first voxels.
std::vector<std::vector<size_t>> partsOf(const Mask& mask) {
  const Steps steps(mask);
  Mask left = mask;
  std::vector<std::vector<size_t>> parts;
  for (size_t start = 0; start < left.values.size(); ++start) {
    if (left.values[start] == 0) continue;
    std::vector<size_t> part{start};
    left.values[start] = 0;
    for (size_t at = 0; at < part.size(); ++at)
      for (const std::ptrdiff_t step : steps.faces()) {
        const size_t next = stepped(part[at], step);
        if (left.values[next] == 0) continue;
        left.values[next] = 0;
        part.push_back(next);
      }
    parts.push_back(std::move(part));
  }
  return parts;
}

/// For each pattern of the eight corners of a cell, the curves in which the mask's surface cuts the
/// cell's faces: on a sphere, one less than there are regions.
std::array<int, 256> countCurves() {
  std::array<int, 256> curves{};
  for (unsigned pattern = 0; pattern < 256; ++pattern) {
    int regions = 0;
    for (const bool inside : {true, false}) {
      unsigned left = inside ? pattern : ~pattern & 255U;
      while (left != 0) {
        ++regions;
        unsigned region = left & (~left + 1), before = 0;
        while (region != before) {
          before = region;
          for (unsigned a = 0; a < 8; ++a)
            for (unsigned b = 0; b < 8; ++b) {
              const unsigned d = a ^ b;
              const bool byFace = (d & (d - 1)) == 0,
                         byEdge = d != 7;  // corners that differ in one, in two coordinates
              if ((before >> a & 1U) != 0 && (inside ? byFace : byEdge)) region |= left & (1U << b);
            }
        }
        left &= ~region;
      }
    }
    curves[pattern] = regions - 1;
  }
  return curves;
}

/// A set of voxels that grows by simple points. `mask` is where it is now: the set itself, or, when
/// it grows inwards, all that it is not.
class Front {
 public:
  /// wanted: the voxels that may join (they have the value `from` in the mask). order: the largest
  /// joins first.
  Front(Mask& mask, const std::vector<float>& order, float sign, const Progress& progress)
      : mask_(mask),
        steps_(mask),
        order_(order),
        sign_(sign),
        progress_(progress),
        wanted_(mask.values.size(), 0) {}

  std::vector<std::uint8_t>& wanted() { return wanted_; }

  void consider(size_t i) {
    if (wanted_[i] != 1) return;
    wanted_[i] = 2;  // waiting
    queue_.emplace(sign_ * order_[i], i);
  }
  void considerAround(size_t i) {
    for (const std::ptrdiff_t step : steps_.around()) consider(stepped(i, step));
  }

  void run() {
    size_t joined = 0, total = 0;
    for (const std::uint8_t w : wanted_) total += w != 0;
    while (!queue_.empty()) {
      const size_t i = queue_.top().index;
      queue_.pop();
      wanted_[i] = 1;
      if (!isSimple(steps_.neighbourhood(mask_, i)))
        continue;  // comes again when something changes round it
      mask_.values[i] ^= 1;
      wanted_[i] = 0;
      considerAround(i);
      if (++joined % 65536 == 0)
        report(progress_, static_cast<double>(joined) / static_cast<double>(total));
    }
  }

 private:
  struct Entry {
    float priority;
    size_t index;
    Entry(float p, size_t i) : priority(p), index(i) {}
    bool operator<(const Entry& other) const {
      return priority != other.priority ? priority < other.priority : index > other.index;
    }
  };

  Mask& mask_;
  const Steps steps_;
  const std::vector<float>& order_;
  float sign_;
  const Progress& progress_;
  std::vector<std::uint8_t> wanted_;  // 0: no, 1: yes, 2: waiting in the queue
  std::priority_queue<Entry> queue_;
};

/// Outwards from the deepest voxel of each part.
Mask grown(const Mask& mask, const std::vector<std::vector<size_t>>& parts,
           const std::vector<float>& depth, const Progress& progress) {
  Mask result(mask.size);
  Front front(result, depth, 1, progress);
  front.wanted() = mask.values;
  std::vector<size_t> seeds;
  for (const auto& part : parts) {
    size_t seed = part.front();
    for (const size_t i : part)
      if (depth[i] > depth[seed] || (depth[i] == depth[seed] && i < seed)) seed = i;
    seeds.push_back(seed);
    result.values[seed] = 1;
    front.wanted()[seed] = 0;
  }
  for (const size_t seed : seeds) front.considerAround(seed);
  front.run();
  return result;
}

/// Inwards from the box of all voxels that are not on the border.
Mask shrunk(const Mask& mask, const std::vector<float>& depth, const Progress& progress) {
  Mask result(mask.size);
  std::fill(result.values.begin(), result.values.end(), std::uint8_t{1});
  forBorder(result, [&](size_t i) { result.values[i] = 0; });
  Front front(result, depth, -1, progress);
  for (size_t i = 0; i < mask.values.size(); ++i)
    front.wanted()[i] = result.values[i] != 0 && mask.values[i] == 0;
  const Eigen::Vector3i n = mask.size;
  for (int k = 1; k < n[2] - 1; ++k)
    for (int j = 1; j < n[1] - 1; ++j) {
      const bool all = k == 1 || j == 1 || k == n[2] - 2 || j == n[1] - 2;
      for (int i = 1; i < n[0] - 1; i += all || n[0] <= 3 ? 1 : n[0] - 3)
        front.consider(result.index(i, j, k));
    }
  front.run();
  return result;
}

std::vector<size_t> differences(const Mask& a, const Mask& b) {
  std::vector<size_t> voxels;
  for (size_t i = 0; i < a.values.size(); ++i)
    if (a.values[i] != b.values[i]) voxels.push_back(i);
  return voxels;
}

HandleRemoval startOfRemoval(const Mask& mask, const std::vector<std::vector<size_t>>& parts) {
  HandleRemoval removal;
  // Without cavities there is one surface per part; each adds 2 - 2 genus.
  Mask filled = mask;
  const bool cavities = fillCavities(filled) > 0;
  const auto surfaces = static_cast<long>(cavities ? partsOf(filled).size() : parts.size());
  removal.handles = surfaces - surfaceEulerCharacteristic(filled) / 2;
  removal.needed = cavities || removal.handles != 0;
  removal.canFill = parts.size() == 1;
  return removal;
}

}  // namespace

DroppedParts keepLargestPart(Mask& mask) {
  requireFreeBorder(mask);
  const auto parts = partsOf(mask);
  DroppedParts dropped;
  if (parts.size() < 2) return dropped;
  const auto largest = std::max_element(
      parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
  for (auto part = parts.begin(); part != parts.end(); ++part) {
    if (part == largest) continue;
    ++dropped.parts;
    dropped.voxels += static_cast<long>(part->size());
    for (const size_t i : *part) mask.values[i] = 0;
  }
  return dropped;
}

long fillCavities(Mask& mask) {
  requireFreeBorder(mask);
  const Steps steps(mask);
  // The outside is flooded from the border. A voxel of the border has neighbours beyond the grid:
  // those are not followed.
  Mask closed = mask;
  std::vector<size_t> open;
  forBorder(mask, [&](size_t i) { closed.values[i] = 1; });
  const auto visit = [&](size_t i) {
    if (closed.values[i] != 0) return;
    closed.values[i] = 1;
    open.push_back(i);
  };
  const Eigen::Vector3i n = mask.size;
  for (int k = 1; k < n[2] - 1; ++k)
    for (int j = 1; j < n[1] - 1; ++j) {
      const bool all = k == 1 || j == 1 || k == n[2] - 2 || j == n[1] - 2;
      for (int i = 1; i < n[0] - 1; i += all || n[0] <= 3 ? 1 : n[0] - 3)
        visit(mask.index(i, j, k));
    }
  while (!open.empty()) {
    const size_t i = open.back();
    open.pop_back();
    for (const std::ptrdiff_t step : steps.facesAndEdges()) visit(stepped(i, step));
  }
  long filled = 0;
  for (size_t i = 0; i < mask.values.size(); ++i)
    if (closed.values[i] == 0) mask.values[i] = 1, ++filled;
  return filled;
}

long surfaceEulerCharacteristic(const Mask& mask) {
  requireFreeBorder(mask);
  static const std::array<int, 256> curves = countCurves();
  // Marching cubes has a vertex on each of the E cut edges of the grid; a cell with e cut edges and
  // c curves has e - 2 c triangles, and each edge bounds four cells: V - F / 2 = E - (4 E - 2 C) /
  // 2 = C - E.
  long sum = 0;
  const auto row = static_cast<size_t>(mask.size[0]),
             slice = row * static_cast<size_t>(mask.size[1]);
  for (int k = 0; k + 1 < mask.size[2]; ++k)
    for (int j = 0; j + 1 < mask.size[1]; ++j) {
      const std::uint8_t* a = mask.values.data() + mask.index(0, j, k);
      const auto column = [&](size_t i) {  // the four corners of a cell at one x, on the even bits
        return static_cast<unsigned>(a[i] | a[i + row] << 2 | a[i + slice] << 4 |
                                     a[i + row + slice] << 6);
      };
      unsigned left = column(0);
      for (size_t i = 0; i + 1 < row; ++i) {
        const unsigned right = column(i + 1);
        if (left != right || (left != 0 && left != 0x55U)) {
          sum += curves[left | right << 1];
          sum -= (left & 1U) != (right & 1U);  // the cell's own edges along x, y, z
          sum -= (left & 1U) != (left >> 2 & 1U);
          sum -= (left & 1U) != (left >> 4 & 1U);
        }
        left = right;
      }
    }
  return sum;
}

HandleRepair HandleRemoval::chosen(HandleRepair wanted) const {
  if (wanted == HandleRepair::Cut || !canFill) return HandleRepair::Cut;
  if (wanted == HandleRepair::Fill) return HandleRepair::Fill;
  return filled.size() < cut.size() ? HandleRepair::Fill : HandleRepair::Cut;
}

RemovedHandles HandleRemoval::apply(Mask& mask, HandleRepair wanted) const {
  RemovedHandles removed;
  removed.handles = handles;
  if (!needed) return removed;
  const bool fills = chosen(wanted) == HandleRepair::Fill;
  const std::vector<size_t>& voxels = fills ? filled : cut;
  for (const size_t i : voxels) mask.values[i] ^= 1;
  removed.by = fills ? RemovedHandles::By::Filling : RemovedHandles::By::Cutting;
  removed.changedVoxels = static_cast<long>(voxels.size());
  return removed;
}

bool needsHandleRemoval(const Mask& mask) {
  requireFreeBorder(mask);
  return startOfRemoval(mask, partsOf(mask)).needed;
}

HandleRemoval findHandleRemoval(const Mask& mask, const std::vector<float>& depth,
                                HandleRepair wanted, const Progress& progress,
                                const std::vector<float>& cutDepth) {
  requireFreeBorder(mask);
  const auto parts = partsOf(mask);
  HandleRemoval removal = startOfRemoval(mask, parts);
  if (!removal.needed) return removal;
  if (wanted != HandleRepair::Fill || !removal.canFill)
    removal.cut = differences(
        mask, grown(mask, parts, cutDepth.empty() ? depth : cutDepth, part(progress, 0, 0.5)));
  if (wanted != HandleRepair::Cut && removal.canFill)
    removal.filled = differences(mask, shrunk(mask, depth, part(progress, 0.5, 1)));
  return removal;
}

RemovedHandles removeHandles(Mask& mask, const std::vector<float>& depth, HandleRepair wanted,
                             const Progress& progress) {
  const HandleRemoval removal = findHandleRemoval(mask, depth, wanted, progress);
  return removal.apply(mask, removal.chosen(wanted));
}

std::vector<std::vector<size_t>> groupsOf(const Eigen::Vector3i& size,
                                          const std::vector<size_t>& voxels) {
  std::set<size_t> left(voxels.begin(), voxels.end());
  const std::ptrdiff_t row = size[0], slice = row * size[1];
  std::vector<std::vector<size_t>> groups;
  while (!left.empty()) {
    std::vector<size_t> group{*left.begin()};
    left.erase(left.begin());
    for (size_t at = 0; at < group.size(); ++at)
      for (int n = 0; n < 27; ++n) {
        const auto next =
            left.find(stepped(group[at], n % 3 - 1 + (n / 3 % 3 - 1) * row + (n / 9 - 1) * slice));
        if (next == left.end()) continue;
        group.push_back(*next);
        left.erase(next);
      }
    groups.push_back(std::move(group));
  }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return groups;
}

void moveBySimplePoints(Mask& mask, const std::vector<float>& values) {
  requireFreeBorder(mask);
  const Steps steps(mask);
  std::vector<std::pair<float, size_t>> wrong;
  const Eigen::Vector3i n = mask.size;
  for (int k = 1; k < n[2] - 1; ++k)
    for (int j = 1; j < n[1] - 1; ++j)
      for (int i = 1; i < n[0] - 1; ++i) {
        const size_t v = mask.index(i, j, k);
        if ((values[v] > 0) != (mask.values[v] != 0) && isSimple(steps.neighbourhood(mask, v)))
          wrong.emplace_back(-std::fabs(values[v]), v);
      }
  std::sort(wrong.begin(), wrong.end());
  for (size_t before = wrong.size() + 1; wrong.size() < before;) {
    before = wrong.size();
    size_t left = 0;
    for (const auto& voxel : wrong) {
      if (isSimple(steps.neighbourhood(mask, voxel.second)))
        mask.values[voxel.second] ^= 1;
      else
        wrong[left++] = voxel;
    }
    wrong.resize(left);
  }
}

}  // namespace sphere_propagation
