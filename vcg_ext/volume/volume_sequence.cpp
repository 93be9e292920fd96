// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/volume_sequence.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/stopwatch.h"

namespace sphere_propagation {
namespace {

constexpr double sameSpacing = 1e-4;  // of a voxel's edge
constexpr double sameSlice = 0.1;     // of the slices' distance

/// Where a stack begins in the voxels of another one on the same grid, but for less than a voxel
/// within the slices; nothing where axes, spacing or the places of the slices are others.
std::optional<Eigen::Vector3i> firstIn(const SliceStack& reference, const SliceStack& stack) {
  const Eigen::Matrix3d axes = reference.toWorld.topLeftCorner<3, 3>(),
                        others = stack.toWorld.topLeftCorner<3, 3>(),
                        steps = axes * reference.spacing.asDiagonal();
  if ((others * stack.spacing.asDiagonal() - steps).norm() > sameSpacing * steps.norm())
    return std::nullopt;
  const Vector3 apart = steps.inverse() * (stack.toWorld.topRightCorner<3, 1>() -
                                           reference.toWorld.topRightCorner<3, 1>());
  const Vector3 whole = apart.array().round();
  if (std::fabs(apart[2] - whole[2]) > sameSlice) return std::nullopt;
  return stack.first + whole.cast<int>();
}

/// The depth of a phase that lies at a place, for the front that cuts: what the union of all is cut
/// at joins last.
std::vector<float> cutLast(std::vector<float> depth, const std::vector<Eigen::Vector3i>& cutOfAll,
                           const Eigen::Vector3i& place, const Mask& mask) {
  for (const Eigen::Vector3i& sample : cutOfAll) {
    const Eigen::Vector3i x = sample - place;
    if (x.minCoeff() >= 0 && (mask.size - x).minCoeff() > 0)
      depth[mask.index(x[0], x[1], x[2])] -= 2 * CommonDepth::reach;  // below all others
  }
  return depth;
}

}  // namespace

VolumeSequence::VolumeSequence(VolumeSurfaceParameters parameters)
    : parameters_(std::move(parameters)) {}

void VolumeSequence::add(const LabelGrid& labels, const Progress& progress) {
  requireSmoothing(parameters_);
  Phase phase;
  SliceStack stack = cutOut(labels, parameters_.interpolation);
  if (stack.betweenSlices || parameters_.interpolation.alignSlices) {
    keptSlices_ += stack.mask.values.size();
    phase.stack = std::move(stack);
  } else {
    WorkingVolume volume = workingVolume(std::move(stack), {}, parameters_);
    report(progress, 0.5);
    goOn(phase, std::move(volume), part(progress, 0.5, 1));
  }
  phases_.push_back(std::move(phase));
  if (keptSlices_ > maxKept) alignOpenSlices({});
  if (kept_ > maxKept) removeOpenHandles({});
  report(progress, 1);
}

void VolumeSequence::goOn(Phase& phase, WorkingVolume volume, const Progress& progress) {
  if (parameters_.cutHandles && common_.agrees(volume.field))
    phase.place = common_.add(volume.field);
  if (parameters_.cutHandles && needsHandleRemoval(volume.mask)) {
    kept_ += volume.mask.values.size();
    phase.volume = std::move(volume);
  } else {
    phase.surface = surfaceOf(std::move(volume), parameters_.smoothing, progress);
  }
}

void VolumeSequence::alignOpenSlices(const Progress& progress) {
  /// Phases whose slices lie at the same places, and where each begins among them.
  struct OnOneGrid {
    std::vector<Phase*> phases;
    std::vector<std::vector<SlicePlace>> places;
    std::vector<int> firsts;
  };
  std::vector<OnOneGrid> grids;
  size_t open = 0;
  for (Phase& phase : phases_) {
    if (!phase.stack) continue;
    ++open;
    const Stopwatch stopwatch;
    const SliceStack& stack = *phase.stack;
    std::optional<Eigen::Vector3i> first;
    auto grid = grids.begin();
    for (; grid != grids.end(); ++grid)
      if ((first = firstIn(*grid->phases.front()->stack, stack))) break;
    if (grid == grids.end()) {
      grids.emplace_back();
      grid = grids.end() - 1;
      first = stack.first;
    }
    std::vector<SlicePlace> places = slicePlaces(stack.mask);
    for (SlicePlace& place : places) {
      place.slice += (*first)[2];
      place.hull.move(first->head<2>());
    }
    grid->phases.push_back(&phase);
    grid->places.push_back(std::move(places));
    grid->firsts.push_back((*first)[2]);
    phase.seconds += stopwatch.seconds();
  }
  size_t done = 0;
  for (const OnOneGrid& grid : grids) {
    const std::vector<PhaseAlignment> alignments =
        alignSlices(grid.places, grid.phases.front()->stack->spacing);
    int sequences = 0;
    for (size_t p = 0; p < grid.phases.size(); ++p) {
      const Stopwatch stopwatch;
      Phase& phase = *grid.phases[p];
      const auto inMask = [&](int slice) { return slice - grid.firsts[p]; };
      std::vector<SliceShift> shifts = alignments[p].shifts;
      for (SliceShift& shift : shifts) shift.slice = inMask(shift.slice);
      for (const int slice : alignments[p].apart)
        phase.apart.push_back(inMask(slice) + phase.stack->first[2]);
      phase.sliceSequence = sliceSequences_ + alignments[p].sequence;
      sequences = std::max(sequences, alignments[p].sequence + 1);
      const std::vector<UnevenSlice> uneven = phase.stack->uneven(shifts);
      const auto share = [&](size_t count) {
        return static_cast<double>(count) / static_cast<double>(open);
      };
      try {
        WorkingVolume volume = workingVolume(std::move(*phase.stack), uneven, parameters_);
        goOn(phase, std::move(volume), part(progress, share(done), share(done + 1)));
      } catch (const Error&) {
        phase.error = std::current_exception();
      }
      phase.stack.reset();
      phase.seconds += stopwatch.seconds();
      ++done;
    }
    sliceSequences_ += sequences;
  }
  keptSlices_ = 0;
}

/// Where the union of the phases on one grid is cut: samples of the common depth.
std::vector<Eigen::Vector3i> VolumeSequence::commonCut(const std::vector<Phase*>& phases) const {
  std::vector<const Phase*> placed;
  for (const Phase* phase : phases)
    if (phase->place) placed.push_back(phase);
  if (placed.size() < 2) return {};
  Eigen::Vector3i low = *placed[0]->place, high = low;
  for (const Phase* phase : placed) {
    low = low.cwiseMin(*phase->place);
    high = high.cwiseMax(*phase->place + phase->volume->mask.size);
  }
  Mask all(high - low);
  for (const Phase* phase : placed) {
    const Mask& mask = phase->volume->mask;
    const Eigen::Vector3i at = *phase->place - low;
    size_t next = 0;
    for (int k = 0; k < mask.size[2]; ++k)
      for (int j = 0; j < mask.size[1]; ++j) {
        std::uint8_t* here = all.values.data() + all.index(at[0], at[1] + j, at[2] + k);
        for (int i = 0; i < mask.size[0]; ++i) here[i] |= mask.values[next++];
      }
  }
  const HandleRemoval removal =
      findHandleRemoval(all, common_.at(low, all.size), HandleRepair::Cut);
  const auto row = static_cast<size_t>(all.size[0]), rows = static_cast<size_t>(all.size[1]);
  std::vector<Eigen::Vector3i> samples;
  for (const size_t i : removal.cut) {
    samples.emplace_back(low + Eigen::Vector3i(static_cast<int>(i % row),
                                               static_cast<int>(i / row % rows),
                                               static_cast<int>(i / row / rows)));
  }
  return samples;
}

void VolumeSequence::removeOpenHandles(const Progress& progress) {
  std::vector<Phase*> open;
  for (Phase& phase : phases_)
    if (phase.volume) open.push_back(&phase);
  size_t cut = 0, filled = 0, done = 0;
  const HandleRepair wanted = parameters_.handleRepair;
  const auto share = [&](size_t count) {
    return static_cast<double>(count) / static_cast<double>(open.size());
  };
  const std::vector<Eigen::Vector3i> cutOfAll =
      wanted == HandleRepair::Fill ? std::vector<Eigen::Vector3i>{} : commonCut(open);
  for (Phase* phase : open) {
    const Stopwatch stopwatch;
    const WorkingVolume& volume = *phase->volume;
    const Progress step = part(progress, 0.7 * share(done), 0.7 * share(done + 1));
    const bool together = common_.phases() > 1 && phase->place;
    phase->volume->surface.handlesAlone = !together;
    if (together) {
      const std::vector<float> depth = common_.at(*phase->place, volume.mask.size);
      phase->removal = findHandleRemoval(volume.mask, depth, wanted, step,
                                         cutLast(depth, cutOfAll, *phase->place, volume.mask));
    } else {
      phase->removal = findHandleRemoval(volume.mask, volume.field.grid.values, wanted, step);
    }
    ++done;
    phase->seconds += stopwatch.seconds();
    if (!phase->removal.canFill) continue;
    cut += phase->removal.cut.size();
    filled += phase->removal.filled.size();
  }
  const HandleRepair fewer = filled < cut ? HandleRepair::Fill : HandleRepair::Cut;
  done = 0;
  for (Phase* phase : open) {
    const Stopwatch stopwatch;
    removeHandles(*phase->volume, phase->removal,
                  wanted == HandleRepair::LessChange ? fewer : wanted);
    phase->surface =
        surfaceOf(std::move(*phase->volume), parameters_.smoothing,
                  part(progress, 0.7 + 0.3 * share(done), 0.7 + 0.3 * share(done + 1)));
    phase->volume.reset();
    phase->removal = {};
    phase->seconds += stopwatch.seconds();
    ++done;
  }
  kept_ = 0;
}

VolumeSurface VolumeSequence::surface(size_t phase, const Progress& progress) {
  Phase& asked = phases_.at(phase);
  const bool slices = asked.stack.has_value();
  if (slices) alignOpenSlices(part(progress, 0, 0.5));
  if (asked.error) std::rethrow_exception(asked.error);
  if (asked.volume) removeOpenHandles(slices ? part(progress, 0.5, 1) : progress);
  if (!asked.surface)
    throw ArgumentError("Sequence of volumes: this phase's surface was handed out before.");
  VolumeSurface surface = std::move(*asked.surface);
  surface.apartSlices = std::move(asked.apart);
  surface.sliceSequence = asked.sliceSequence;
  surface.seconds = asked.seconds;
  asked.surface.reset();
  return surface;
}

}  // namespace sphere_propagation
