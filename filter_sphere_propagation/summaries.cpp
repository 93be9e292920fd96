// SPDX-License-Identifier: GPL-3.0-only
#include "filter_sphere_propagation/summaries.h"

#include <algorithm>
#include <vector>

#include "filter_sphere_propagation/messages.h"

namespace sphere_propagation {

std::string hiddenLeftOut(const host::Layers& layers, const std::vector<host::LayerKind>& kinds) {
  constexpr size_t maxNamed = 5;
  std::vector<std::string> hidden;
  for (const host::LayerKind kind : kinds)
    for (const host::Layer& layer : layers.all(kind))
      if (!layer.visible()) hidden.push_back(layer.label());
  if (hidden.empty()) return "";
  std::string names;
  for (size_t i = 0; i < std::min(hidden.size(), maxNamed); ++i)
    names += (i > 0 ? ", \"" : "\"") + hidden[i] + "\"";
  if (hidden.size() > maxNamed)
    names += " and " + std::to_string(hidden.size() - maxNamed) + " more";
  return host::said(messages::hiddenLayers, names);
}

std::string nextFilter(const host::Layers& layers, size_t mapped) {
  if (mapped == 0) return host::said(messages::nextIsRoot);
  if (mapped < layers.visible(host::LayerKind::Surface).size())
    return host::said(messages::nextIsPropagation);
  return host::said(layers.visible(host::LayerKind::Landmarks).empty() ? messages::nextIsRemeshing
                                                                       : messages::nextIsModel);
}

Eigen::AlignedBox3d shownBeside(const host::Layers& layers, host::LayerKind kind) {
  Eigen::AlignedBox3d box;
  for (const host::LayerKind other :
       {host::LayerKind::Surface, host::LayerKind::Landmarks, host::LayerKind::Sphere,
        host::LayerKind::Fit, host::LayerKind::Morph, host::LayerKind::Model}) {
    // The model stands last: what is made anew before it does not move behind it.
    if (other == kind || other == host::LayerKind::Model) continue;
    for (const host::Layer& layer : layers.visible(other)) box.extend(layer.shownBox());
  }
  return box;
}

}  // namespace sphere_propagation
