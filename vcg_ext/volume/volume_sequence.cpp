// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/volume_sequence.h"

#include <utility>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {

VolumeSequence::VolumeSequence(VolumeSurfaceParameters parameters)
    : parameters_(std::move(parameters)) {}

void VolumeSequence::add(const LabelGrid& labels, const Progress& progress) {
  Phase phase;
  WorkingVolume volume = workingVolume(labels, parameters_, part(progress, 0, 0.5));
  if (parameters_.cutHandles && common_.agrees(volume.field))
    phase.place = common_.add(volume.field);
  if (parameters_.cutHandles && needsHandleRemoval(volume.mask)) {
    kept_ += volume.mask.values.size();
    phase.volume = std::move(volume);
  } else {
    phase.surface = surfaceOf(std::move(volume), parameters_.smoothing, part(progress, 0.5, 1));
  }
  phases_.push_back(std::move(phase));
  if (kept_ > maxKept) removeOpenHandles({});
  report(progress, 1);
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
  for (Phase* phase : open) {
    const WorkingVolume& volume = *phase->volume;
    const Progress step = part(progress, 0.7 * share(done), 0.7 * share(done + 1));
    phase->removal =
        common_.phases() > 1 && phase->place
            ? findHandleRemoval(volume.mask, common_.at(*phase->place, volume.mask.size), wanted,
                                step)
            : findHandleRemoval(volume.mask, volume.field.grid.values, wanted, step);
    ++done;
    if (!phase->removal.canFill) continue;
    cut += phase->removal.cut.size();
    filled += phase->removal.filled.size();
  }
  const HandleRepair fewer = filled < cut ? HandleRepair::Fill : HandleRepair::Cut;
  done = 0;
  for (Phase* phase : open) {
    removeHandles(*phase->volume, phase->removal,
                  wanted == HandleRepair::LessChange ? fewer : wanted);
    phase->surface =
        surfaceOf(std::move(*phase->volume), parameters_.smoothing,
                  part(progress, 0.7 + 0.3 * share(done), 0.7 + 0.3 * share(done + 1)));
    phase->volume.reset();
    phase->removal = {};
    ++done;
  }
  kept_ = 0;
}

VolumeSurface VolumeSequence::surface(size_t phase, const Progress& progress) {
  Phase& asked = phases_.at(phase);
  if (asked.volume) removeOpenHandles(progress);
  if (!asked.surface)
    throw ArgumentError("Sequence of volumes: this phase's surface was handed out before.");
  VolumeSurface surface = std::move(*asked.surface);
  asked.surface.reset();
  return surface;
}

}  // namespace sphere_propagation
