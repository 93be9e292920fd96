// SPDX-License-Identifier: GPL-3.0-only
#include "filter_sphere_propagation/largest_layer.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "filter_sphere_propagation/reporting.h"
#include "vcg_ext/base/statistics.h"

namespace sphere_propagation {
namespace {

constexpr double clearly = 1.05;  // voxels alone change a volume by a few per cent
// What is that many times as large as all smaller ones, and as the median, is of another unit.
constexpr double apart = 2, unusual = 3;

}  // namespace

LargestLayer::LargestLayer(const std::vector<host::Layer>& surfaces) {
  for (const host::Layer& layer : surfaces) {
    entries_.push_back({layer.id(), layer.label(), layer.enclosedVolume()});
  }
  std::vector<size_t> order(entries_.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto volume = [this](size_t i) { return entries_[i].volume; };
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return volume(a) > volume(b); });
  std::vector<double> volumes;
  for (const Entry& entry : entries_) volumes.push_back(entry.volume);
  const double median = medianOf(std::move(volumes));
  if (!order.empty()) largest_ = order.front();
  for (size_t k = 0; k < order.size() / 4; ++k)
    if (volume(order[k]) > apart * volume(order[k + 1]) && volume(order[k]) > unusual * median)
      largest_ = order[k + 1];
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
