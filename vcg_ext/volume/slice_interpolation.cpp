// SPDX-License-Identifier: GPL-3.0-only
// S. P. Raya, J. K. Udupa, Shape-based interpolation of multidimensional objects, 1990.

#include "vcg_ext/volume/slice_interpolation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/sentence.h"
#include "vcg_ext/volume/distance_transform.h"
#include "vcg_ext/volume/slice_holes.h"

namespace sphere_propagation {
namespace {

constexpr int margin = 4;        // samples of the working grid round the labels
constexpr double maxGrid = 2e8;  // samples
constexpr double maxPadding =
    8;  // voxels with room for the working grid's margin, by those of the label's box
constexpr double anisotropy = 1.5;
constexpr size_t leastSlices = 4;  // for the ends to be compared
// In mm, radii, and a part of the slice. Half slices at a valve lie off the line, too, but on the
// next one: of 414 ends of two hearts, as drawn and in every fifth and seventh slice, none is here.
constexpr double farOffLine = 12, farOffInRadii = 0.5, farBeside = 0.3;
// Where volumes were trimmed to ellipsoids of 20 voxels and more, at most .17 of the widest section
// meets the border, and of two hearts' .28; across slices an apex has up to .4.
constexpr double cutInSpace = 0.35, cutAcross = 0.5;
// How much smaller one of the slices beside a gap may be: far apart, they differ more.
constexpr double minShareAcross = 0.1, minShareInSpace = 0.5;

std::string listOf(const std::vector<std::int32_t>& labels) {
  std::string text;
  for (const std::int32_t label : labels)
    text += (text.empty() ? "" : ", ") + std::to_string(label);
  return (labels.size() == 1 ? "label " : "labels ") + text;
}

/// Throws when one of the labels occurs nowhere.
void requireLabels(const LabelGrid& grid, const std::vector<std::int32_t>& labels) {
  const auto counts = grid.count();
  std::vector<std::int32_t> absent;
  for (const std::int32_t label : labels)
    if (counts.count(label) == 0) absent.push_back(label);
  if (absent.empty()) return;
  std::string found;
  int listed = 0;
  for (const auto& label : counts)
    if (++listed <= 10)
      found += (found.empty() ? "" : ", ") +
               (label.first == LabelGrid::beyond ? "beyond 32 bits" : std::to_string(label.first));
  if (listed > 10) found += " and " + std::to_string(listed - 10) + " more";
  throw AbsentLabelError(Finding(found.empty() ? Fault::OnlyBackground : Fault::AbsentLabel)
                             .of(static_cast<long>(absent.size()))
                             .saying(listOf(absent))
                             .against(found));
}

/// sections: of each axis, the number of voxels with the labels at each index.
std::vector<BorderContact> bordersOf(const std::array<std::vector<long>, 3>& sections,
                                     int acrossAxis) {
  std::vector<BorderContact> borders;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<long>& of = sections[static_cast<size_t>(axis)];
    const auto widest = static_cast<double>(*std::max_element(of.begin(), of.end()));
    for (const size_t index : {size_t{0}, of.size() - 1}) {
      const double share = static_cast<double>(of[index]) / widest;
      if (share > (axis == acrossAxis ? cutAcross : cutInSpace) && of.size() > 1)
        borders.push_back({axis, static_cast<int>(index), share});
    }
  }
  return borders;
}

/// room: to be left empty round the labels, mm.
SliceStack stackOf(const LabelGrid& grid, const std::vector<std::int32_t>& labels, double room) {
  const std::vector<std::int32_t> wanted = [&] {
    std::vector<std::int32_t> sorted = labels;
    std::sort(sorted.begin(), sorted.end());
    return sorted;
  }();
  const auto inside = [&](std::int32_t label) {
    return wanted.size() == 1 ? label == wanted[0]
                              : std::binary_search(wanted.begin(), wanted.end(), label);
  };
  Eigen::Vector3i low = grid.size, high = Eigen::Vector3i::Constant(-1);
  SliceStack stack;
  long voxels = 0;
  std::array<std::vector<long>, 3> sections;
  for (int axis = 0; axis < 3; ++axis)
    sections[static_cast<size_t>(axis)].assign(static_cast<size_t>(grid.size[axis]), 0);
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j) {
      const std::int32_t* row = grid.values.data() + grid.index(0, j, k);
      for (int i = 0; i < grid.size[0]; ++i) {
        if (!inside(row[i])) continue;
        ++voxels;
        ++sections[0][static_cast<size_t>(i)];
        ++sections[1][static_cast<size_t>(j)];
        ++sections[2][static_cast<size_t>(k)];
        low = low.cwiseMin(Eigen::Vector3i(i, j, k));
        high = high.cwiseMax(Eigen::Vector3i(i, j, k));
      }
    }

  const Vector3 spacing = grid.spacing();
  int last = 2;  // the slices' axis
  for (const int axis : {1, 0})
    if (spacing[axis] > spacing[last] * (1 + 1e-6)) last = axis;
  const std::array<int, 3> axes{(last + 1) % 3, (last + 2) % 3, last};
  Eigen::Vector3i padded;
  const Vector3 box = (high - low).cast<double>().array() + 1,
                pads = (room * spacing.cwiseInverse()).array().ceil() + 1;
  if ((box + 2 * pads).prod() > std::max(maxGrid, maxPadding * box.prod())) {
    std::ostringstream text;
    const Vector3 size = box.cwiseProduct(spacing);
    text << size[0] << " x " << size[1] << " x " << size[2];
    throw ParameterError(Finding(Fault::WorkingVoxelsLarge).saying(text.str()));
  }
  for (int a = 0; a < 3; ++a) {
    const int axis = axes[static_cast<size_t>(a)];
    const int pad = static_cast<int>(pads[axis]);
    stack.spacing[a] = spacing[axis];
    stack.first[a] = low[axis] - pad;
    padded[a] = high[axis] - low[axis] + 1 + 2 * pad;
    stack.toWorld.col(a) = grid.toWorld.col(axis) / spacing[axis];
  }
  stack.betweenSlices = stack.spacing[2] >= anisotropy * stack.spacing.head<2>().minCoeff();
  stack.borders = bordersOf(sections, stack.betweenSlices ? last : -1);
  stack.toWorld.col(3) = grid.toWorld.col(3);
  stack.labelVolume = static_cast<double>(voxels) * grid.voxelVolume();
  stack.mask = Mask(padded);
  Eigen::Vector3i at;
  for (at[2] = low[2]; at[2] <= high[2]; ++at[2])
    for (at[1] = low[1]; at[1] <= high[1]; ++at[1])
      for (at[0] = low[0]; at[0] <= high[0]; ++at[0])
        if (inside(grid.values[grid.index(at[0], at[1], at[2])]))
          stack.mask(at[axes[0]] - stack.first[0], at[axes[1]] - stack.first[1],
                     at[axes[2]] - stack.first[2]) = 1;
  return stack;
}

/// The slices with a label, and which of the empty ones between them are to be interpolated.
struct Slices {
  struct Run {
    int first, last;        // of slices that hang together
    std::vector<int> used;  // those with a label
  };
  std::vector<Run> runs;
  int interpolated = 0;
};

Slices slicesOf(const Mask& mask, int longestGap, double minShare) {
  Slices slices;
  long before = 0;
  const size_t slice = mask.index(0, 0, 1);
  for (int k = 0; k < mask.size[2]; ++k) {
    const auto begin = mask.values.begin() + static_cast<std::ptrdiff_t>(slice) * k;
    const long count =
        std::count(begin, begin + static_cast<std::ptrdiff_t>(slice), std::uint8_t{1});
    if (count == 0) continue;
    const int gap = slices.runs.empty() ? 0 : k - slices.runs.back().last - 1;
    const bool comparable = static_cast<double>(std::min(count, before)) >=
                            minShare * static_cast<double>(std::max(count, before));
    if (slices.runs.empty() || gap > longestGap || (gap > 0 && !comparable)) {
      slices.runs.push_back({k, k, {k}});
    } else {
      slices.runs.back().last = k;
      slices.runs.back().used.push_back(k);
      slices.interpolated += gap;
    }
    before = count;
  }
  return slices;
}

/// Where a sample lies between the voxels of one axis.
struct Between {
  int voxel;
  float weight;  // of the next one
};

Between between(double position, int count) {
  const int voxel = std::clamp(static_cast<int>(std::floor(position)), 0, std::max(count - 2, 0));
  return {voxel, static_cast<float>(std::clamp(position - voxel, 0.0, 1.0))};
}

/// Values along one line, given at increasing whole positions, as a smooth function without new
/// extremes: slopes are the weighted harmonic means of the secants beside them (F. N. Fritsch, J.
/// Butland, 1984).
class MonotoneCubic {
 public:
  void set(const std::vector<int>& positions, const std::vector<float>& values) {
    positions_ = &positions;
    values_ = values;
    const size_t n = positions.size();
    slopes_.assign(n, 0);
    if (n < 2) return;
    const auto step = [&](size_t i) { return static_cast<float>(positions[i + 1] - positions[i]); };
    const auto secant = [&](size_t i) { return (values_[i + 1] - values_[i]) / step(i); };
    slopes_[0] = secant(0);
    slopes_[n - 1] = secant(n - 2);
    for (size_t i = 1; i + 1 < n; ++i) {
      const float a = secant(i - 1), b = secant(i);
      if (a * b <= 0) continue;
      const float wa = 2 * step(i) + step(i - 1), wb = step(i) + 2 * step(i - 1);
      slopes_[i] = (wa + wb) / (wa / a + wb / b);
    }
  }
  /// Constant beyond both ends.
  float operator()(double x) const {
    const std::vector<int>& p = *positions_;
    if (x <= p.front()) return values_.front();
    if (x >= p.back()) return values_.back();
    const auto i = static_cast<size_t>(std::upper_bound(p.begin(), p.end(), x) - p.begin()) - 1;
    const auto h = static_cast<float>(p[i + 1] - p[i]);
    const float t = static_cast<float>(x - p[i]) / h, s = 1 - t;
    return s * s * ((1 + 2 * t) * values_[i] + t * h * slopes_[i]) +
           t * t * ((1 + 2 * s) * values_[i + 1] - s * h * slopes_[i + 1]);
  }

 private:
  const std::vector<int>* positions_ = nullptr;
  std::vector<float> values_, slopes_;
};

/// A grid of cubes that holds the stack's labels with the margin, aligned with its first voxel.
ScalarGrid workingGrid(const SliceStack& stack, const Eigen::Vector3i& low,
                       const Eigen::Vector3i& high, double h) {
  const Vector3 from = low.cast<double>().cwiseProduct(stack.spacing),
                to = high.cast<double>().cwiseProduct(stack.spacing);
  ScalarGrid grid;
  grid.spacing = Vector3::Constant(h);
  Eigen::Vector3d size;
  for (int a = 0; a < 3; ++a) {
    const double before = std::ceil(stack.spacing[a] / 2 / h) + margin;
    grid.origin[a] = from[a] - before * h;
    size[a] = std::ceil((to[a] + stack.spacing[a] / 2 - grid.origin[a]) / h) + margin + 1;
  }
  if (!(size.prod() <= maxGrid)) {
    throw ParameterError(
        Finding(Fault::WorkingVoxelsSmall).saying(numeral(size.prod())).at(h, 0, maxGrid));
  }
  grid.size = size.cast<int>();
  grid.values.resize(grid.voxelCount());
  return grid;
}

/// The signed distances of the slices, each sampled on the working grid's x and y.
std::vector<std::vector<float>> sampledSlices(const std::vector<float>& distance,
                                              const SliceStack& stack, const ScalarGrid& grid) {
  const auto nx = static_cast<size_t>(grid.size[0]), ny = static_cast<size_t>(grid.size[1]);
  std::vector<Between> xs, ys;
  for (size_t i = 0; i < nx; ++i)
    xs.push_back(
        between((grid.origin[0] + static_cast<double>(i) * grid.spacing[0]) / stack.spacing[0],
                stack.mask.size[0]));
  for (size_t j = 0; j < ny; ++j)
    ys.push_back(
        between((grid.origin[1] + static_cast<double>(j) * grid.spacing[1]) / stack.spacing[1],
                stack.mask.size[1]));
  const auto row = static_cast<size_t>(stack.mask.size[0]);
  std::vector<std::vector<float>> sampled(static_cast<size_t>(stack.mask.size[2]));
  for (int k = 0; k < stack.mask.size[2]; ++k) {
    std::vector<float>& values = sampled[static_cast<size_t>(k)];
    const float* slice = distance.data() + stack.mask.index(0, 0, k);
    if (!std::isfinite(slice[0])) continue;  // empty
    values.reserve(nx * ny);
    for (const Between& y : ys)
      for (const Between& x : xs) {
        const float* at = slice + static_cast<size_t>(y.voxel) * row + x.voxel;
        const float a = at[0] + x.weight * (at[1] - at[0]),
                    b = at[row] + x.weight * (at[row + 1] - at[row]);
        values.push_back(a + y.weight * (b - a));
      }
  }
  return sampled;
}

/// Signed distances in the slices, by slice and column of the working grid: of the shape, and,
/// where it has holes, of these and of what it is with them.
struct SampledStack {
  using Samples = std::vector<std::vector<float>>;
  Samples shape, filled, holes;
};

/// How the slices of a run go over into each other, along the columns of the working grid.
class Column {
 public:
  Column(const Slices::Run& run, const SliceHoles& holes, const SampledStack& samples)
      : used_(run.used), samples_(samples) {
    const auto deepest = [](const std::vector<float>& distance) {
      return *std::max_element(distance.begin(), distance.end());
    };
    for (const int k : used_)
      if (holes.has(k)) holedSlices_.push_back(k);
    for (size_t u = 0; u + 1 < used_.size(); ++u) {
      Gap gap;
      const int below = used_[u], above = used_[u + 1];
      if (holes.leadThrough(below, above)) {
        anyWall_ = true;
        gap.kind = holes.has(below) && holes.has(above) ? Gap::Kind::Wall : Gap::Kind::Closing;
        gap.holed = holes.has(below) ? below : above;
        gap.closed = holes.has(below) ? above : below;
        if (gap.kind == Gap::Kind::Closing)
          gap.depth = deepest(samples.filled[static_cast<size_t>(gap.closed)]) +
                      deepest(samples.holes[static_cast<size_t>(gap.holed)]);
      }
      gaps_.push_back(gap);
    }
  }
  ~Column() = default;
  Column(const Column&) = delete;  // its lines point to its slices
  Column& operator=(const Column&) = delete;

  void moveTo(size_t column) {
    set(shape_, used_, samples_.shape, column);
    if (!anyWall_) return;
    set(filled_, used_, samples_.filled, column);
    set(holes_, holedSlices_, samples_.holes, column);
  }

  /// x: in slices.
  float operator()(double x) const {
    if (!anyWall_ || x <= used_.front() || x >= used_.back()) return shape_(x);
    const Gap& gap =
        gaps_[static_cast<size_t>(std::upper_bound(used_.begin(), used_.end(), x) - used_.begin()) -
              1];
    if (gap.kind == Gap::Kind::Plain) return shape_(x);
    if (gap.kind == Gap::Kind::Wall) return std::min(filled_(x), -holes_(x));
    // The hole tapers to a point half way, along the surface that closes it.
    const auto t = static_cast<float>((x - gap.holed) / (gap.closed - gap.holed));
    return std::min(filled_(x),
                    -((1 - t) * holes_(gap.holed) + t * (filled_(gap.closed) - gap.depth)));
  }

 private:
  struct Gap {
    enum class Kind { Plain, Wall, Closing } kind = Kind::Plain;
    int holed = 0, closed = 0;  // Closing: the slice with the hole, and the one that closes it
    float depth = 0;            // of the hole and of what closes it
  };

  void set(MonotoneCubic& line, const std::vector<int>& slices,
           const SampledStack::Samples& samples, size_t column) {
    values_.clear();
    for (const int k : slices) values_.push_back(samples[static_cast<size_t>(k)][column]);
    line.set(slices, values_);
  }

  std::vector<int> used_, holedSlices_;
  const SampledStack& samples_;
  std::vector<Gap> gaps_;
  bool anyWall_ = false;
  MonotoneCubic shape_, filled_, holes_;
  std::vector<float> values_;
};

/// Signed distances in the slices, and smoothly from one to the next.
void interpolateAcross(const SliceStack& stack, const Slices& slices, ScalarGrid& grid) {
  const auto sampled = [&](const Mask& mask) {
    return sampledSlices(signedDistance(mask, stack.spacing, 2), stack, grid);
  };
  const SliceHoles holes(stack.mask);
  SampledStack samples{sampled(stack.mask), {}, {}};
  if (holes.any()) {
    samples.filled = sampled(holes.filled());
    samples.holes = sampled(holes.holes());
  }
  std::fill(grid.values.begin(), grid.values.end(), -std::numeric_limits<float>::infinity());
  const double s = stack.spacing[2];
  const size_t plane = grid.index(0, 0, 1);
  for (const Slices::Run& run : slices.runs) {
    Column line(run, holes, samples);
    for (size_t column = 0; column < plane; ++column) {
      line.moveTo(column);
      for (int z = 0; z < grid.size[2]; ++z) {
        const double height = grid.origin[2] + z * grid.spacing[2];
        const double toCap =
            std::min(height - (run.first - 0.5) * s, (run.last + 0.5) * s - height);
        float& value = grid.values[column + plane * static_cast<size_t>(z)];
        value = std::max(value, std::min(line(height / s), static_cast<float>(toCap)));
      }
    }
  }
}

/// Fills the empty slices between others where the shape interpolated between these is.
void fillGaps(SliceStack& stack, const Slices& slices) {
  const std::vector<float> distance = signedDistance(stack.mask, stack.spacing, 2);
  const size_t plane = stack.mask.index(0, 0, 1);
  for (const Slices::Run& run : slices.runs)
    for (size_t u = 0; u + 1 < run.used.size(); ++u)
      for (int k = run.used[u] + 1; k < run.used[u + 1]; ++k) {
        const float t =
            static_cast<float>(k - run.used[u]) / static_cast<float>(run.used[u + 1] - run.used[u]);
        for (size_t i = 0; i < plane; ++i) {
          const float a = distance[plane * static_cast<size_t>(run.used[u]) + i];
          const float b = distance[plane * static_cast<size_t>(run.used[u + 1]) + i];
          stack.mask.values[plane * static_cast<size_t>(k) + i] = a + t * (b - a) > 0;
        }
      }
}

/// Signed distances in space.
void interpolateInSpace(const SliceStack& stack, ScalarGrid& grid) {
  const auto sampled = [&] {
    return sampledSlices(signedDistance(stack.mask, stack.spacing), stack, grid);
  }();
  const size_t plane = grid.index(0, 0, 1);
  for (int z = 0; z < grid.size[2]; ++z) {
    const Between at =
        between((grid.origin[2] + z * grid.spacing[2]) / stack.spacing[2], stack.mask.size[2]);
    const std::vector<float>&a = sampled[static_cast<size_t>(at.voxel)],
          &b = sampled[static_cast<size_t>(at.voxel) + 1];
    for (size_t i = 0; i < plane; ++i)
      grid.values[plane * static_cast<size_t>(z) + i] = a[i] + at.weight * (b[i] - a[i]);
  }
}

struct SliceCentre {
  int slice = 0;
  long voxels = 0;
  Vector2 centre = Vector2::Zero();  // mm
};

std::vector<SliceCentre> centresOf(const Mask& mask, const Vector3& spacing) {
  std::vector<SliceCentre> centres;
  for (int k = 0; k < mask.size[2]; ++k) {
    SliceCentre of{k, 0, Vector2::Zero()};
    for (int j = 0; j < mask.size[1]; ++j)
      for (int i = 0; i < mask.size[0]; ++i)
        if (mask(i, j, k) != 0) {
          ++of.voxels;
          of.centre += Vector2(i, j);
        }
    if (of.voxels == 0) continue;
    of.centre = (of.centre / static_cast<double>(of.voxels)).cwiseProduct(spacing.head<2>());
    centres.push_back(of);
  }
  return centres;
}

/// Of slice a, what lies beside slice b.
double shareBeside(const Mask& mask, int a, int b) {
  long all = 0, beside = 0;
  for (int j = 0; j < mask.size[1]; ++j)
    for (int i = 0; i < mask.size[0]; ++i) {
      if (mask(i, j, a) == 0) continue;
      ++all;
      if (mask(i, j, b) == 0) ++beside;
    }
  return static_cast<double>(beside) / static_cast<double>(all);
}

std::vector<UnevenSlice> farEndsOf(const SliceStack& stack,
                                   const std::vector<UnevenSlice>& uneven) {
  const SliceHoles holes(stack.mask);
  const Mask& mask = holes.filled();
  const std::vector<SliceCentre> centres = centresOf(mask, stack.spacing);
  std::vector<UnevenSlice> far;
  const size_t count = centres.size();
  if (count < leastSlices) return far;
  for (const bool last : {false, true}) {
    const auto at = [&](size_t i) { return centres[last ? count - 1 - i : i]; };
    const SliceCentre end = at(0), next = at(1), third = at(2);
    const bool known = std::any_of(uneven.begin(), uneven.end(), [&](const UnevenSlice& slice) {
      return std::abs(slice.slice - stack.first[2] - next.slice) <= 1;
    });
    if (known || std::abs(end.slice - third.slice) != 2) continue;
    const double off = (end.centre - 2 * next.centre + third.centre).norm();
    const double radius =
        std::sqrt(static_cast<double>(next.voxels) * stack.spacing[0] * stack.spacing[1] / pi);
    if (off <= std::max(farOffLine, farOffInRadii * radius) ||
        shareBeside(mask, end.slice, next.slice) <= farBeside)
      continue;
    far.emplace_back();
    far.back().slice = end.slice + stack.first[2];
    far.back().shift = off;
  }
  return far;
}

}  // namespace

std::vector<UnevenSlice> SliceStack::uneven(const std::vector<SliceShift>& shifts) const {
  std::vector<UnevenSlice> slices;
  for (const SliceShift& shift : shifts)
    slices.push_back({shift.slice + first[2],
                      shift.voxels.cast<double>().cwiseProduct(spacing.head<2>()).norm(),
                      shift.alone, shift.voxels});
  return slices;
}

SliceStack cutOut(const LabelGrid& labels, const SliceInterpolationParameters& parameters) {
  labels.check();
  if (parameters.labels.empty()) throw ArgumentError("Label volume: no label was given.");
  requireRange("voxel size", parameters.voxelSize, Range::atLeast(0));
  requireRange("longest gap in slices", parameters.longestGap, Range::atLeast(0));
  for (const std::int32_t label : parameters.labels)
    if (label == 0)
      throw ArgumentError("Label volume: 0 is the background; the labels must be other numbers.");
  requireLabels(labels, parameters.labels);
  const double h = parameters.voxelSize > 0 ? parameters.voxelSize : labels.spacing().minCoeff();
  SliceStack stack = stackOf(labels, parameters.labels, (margin + 2) * h);
  stack.voxelSize = h;
  return stack;
}

InterpolatedLabels interpolateSlices(const LabelGrid& labels,
                                     const SliceInterpolationParameters& parameters) {
  SliceStack stack = cutOut(labels, parameters);
  std::vector<UnevenSlice> uneven;
  if (stack.betweenSlices || parameters.alignSlices)
    uneven = stack.uneven(findSliceShifts(stack.mask, stack.spacing));
  return interpolateSlices(std::move(stack), uneven, parameters);
}

InterpolatedLabels interpolateSlices(SliceStack stack, const std::vector<UnevenSlice>& uneven,
                                     const SliceInterpolationParameters& parameters) {
  InterpolatedLabels result;
  result.labelVolume = stack.labelVolume;
  result.betweenSlices = stack.betweenSlices;
  result.unevenSlices = uneven;
  result.borders = stack.borders;
  if (stack.betweenSlices) result.farEnds = farEndsOf(stack, uneven);
  if (parameters.alignSlices) {
    std::vector<SliceShift> shifts;
    for (const UnevenSlice& slice : uneven)
      shifts.push_back({slice.slice - stack.first[2], slice.voxels, slice.alone});
    stack.first.head<2>() -= moveSlices(stack.mask, shifts);
  }
  const Slices slices = slicesOf(stack.mask, parameters.longestGap,
                                 result.betweenSlices ? minShareAcross : minShareInSpace);
  result.interpolatedSlices = slices.interpolated;
  // In the stack's own indices; the matrix takes care of where it begins.
  Eigen::Vector3i low = stack.mask.size, high = Eigen::Vector3i::Zero();
  for (int k = 0; k < stack.mask.size[2]; ++k)
    for (int j = 0; j < stack.mask.size[1]; ++j)
      for (int i = 0; i < stack.mask.size[0]; ++i)
        if (stack.mask(i, j, k) != 0) {
          low = low.cwiseMin(Eigen::Vector3i(i, j, k));
          high = high.cwiseMax(Eigen::Vector3i(i, j, k));
        }
  result.grid = workingGrid(stack, low, high, stack.voxelSize);
  if (result.betweenSlices) {
    interpolateAcross(stack, slices, result.grid);
  } else {
    if (slices.interpolated > 0) fillGaps(stack, slices);
    interpolateInSpace(stack, result.grid);
  }
  result.stack = {stack.mask, stack.spacing, stack.first[2]};
  result.toWorld = stack.toWorld;
  result.toWorld.col(3) +=
      stack.toWorld.leftCols<3>() * stack.first.cast<double>().cwiseProduct(stack.spacing);
  return result;
}

}  // namespace sphere_propagation
