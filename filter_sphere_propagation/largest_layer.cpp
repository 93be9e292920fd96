// SPDX-License-Identifier: GPL-3.0-only
#include "filter_sphere_propagation/largest_layer.h"

#include "filter_sphere_propagation/reporting.h"

namespace sphere_propagation {
namespace {

constexpr double clearly = 1.05;  // voxels alone change a volume by a few per cent

}  // namespace

LargestLayer::LargestLayer(const std::vector<host::Layer>& surfaces) {
  for (const host::Layer& layer : surfaces) {
    entries_.push_back({layer.id(), layer.label(), layer.enclosedVolume()});
    if (entries_.back().volume > entries_[largest_].volume) largest_ = entries_.size() - 1;
  }
}

double LargestLayer::volumeOf(int layerId) const {
  for (const Entry& entry : entries_)
    if (entry.id == layerId) return entry.volume;
  return -1;
}

bool LargestLayer::beats(int layerId) const {
  const double volume = volumeOf(layerId);
  return volume >= 0 && entries_[largest_].volume > clearly * volume;
}

std::string LargestLayer::help() const {
  if (entries_.size() < 2 || entries_[largest_].volume <= 0) return "";
  const Entry& entry = entries_[largest_];
  return "The layer of largest volume is " + std::to_string(entry.id) + ", \"" + entry.label +
         "\" (" + shortNumber(entry.volume) +
         "): of a heart cycle that is end-diastole, a good root.";
}

std::string LargestLayer::note(int layerId) const {
  if (!beats(layerId)) return "";
  const Entry& entry = entries_[largest_];
  return "layer " + std::to_string(entry.id) + " \"" + entry.label + "\" is the largest (volume " +
         shortNumber(entry.volume) + ", this one " + shortNumber(volumeOf(layerId)) + ")";
}

}  // namespace sphere_propagation
