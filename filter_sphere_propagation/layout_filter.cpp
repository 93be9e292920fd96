// SPDX-License-Identifier: GPL-3.0-only
// "Lay layers side by side": all that is visible, so that nothing hides anything; and back again.

#include <algorithm>
#include <utility>

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/messages.h"
#include "filter_sphere_propagation/model_layers.h"
#include "host/help.h"
#include "vcg_ext/display/side_by_side.h"

namespace sphere_propagation {
namespace {

/// The spheres that "Load anchors" shows of a layer go where it goes.
std::vector<host::Layer> anchorsOf(const host::Layer& layer, const host::Layers& layers) {
  std::vector<host::Layer> its;
  for (const host::Layer& other : layers.visible(host::LayerKind::Anchors))
    if (other.label() == layer.derivedLabel("anchors")) its.push_back(other);
  return its;
}

class LayoutFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return help_.describe(host::Menu::Layer, host::Arity::VisibleLayers);
  }

  std::vector<host::Parameter> parameters(const host::Layers&) const override { return {}; }

  host::Outputs run(host::Task& task) const override {
    std::vector<std::vector<host::Layer>> groups;
    bool allAside = true;
    int count = 0;
    for (const host::LayerKind kind :
         {host::LayerKind::Surface, host::LayerKind::Landmarks, host::LayerKind::Sphere,
          host::LayerKind::Fit, host::LayerKind::Morph, host::LayerKind::Model}) {
      std::vector<host::Layer> group;
      for (const host::Layer& layer : task.layers.visible(kind))
        if (!layer.shownBox().isEmpty()) group.push_back(layer);
      for (const host::Layer& layer : group) allAside = allAside && layer.isShownAside();
      count += static_cast<int>(group.size());
      groups.push_back(std::move(group));
    }
    if (count == 0) throw host::Refusal(messages::nothingToLayOut);
    if (allAside) {
      for (const auto& group : groups)
        for (const host::Layer& layer : group) {
          task.changes.showInPlace(layer);
          for (const host::Layer& its : anchorsOf(layer, task.layers))
            task.changes.showInPlace(its);
        }
      task.say(messages::layersInPlace, count);
    } else {
      Eigen::AlignedBox3d beside;
      for (const auto& group : groups) {
        std::vector<Eigen::AlignedBox3d> boxes;
        std::vector<std::string> labels;
        for (const host::Layer& layer : group) {
          boxes.push_back(layer.shownBox());
          labels.push_back(layer.label());
        }
        const std::vector<Vector3> moves = sideBySide(boxes, beside, cellsOfModel(labels));
        for (size_t i = 0; i < group.size(); ++i) {
          task.changes.showAside(group[i], moves[i]);
          for (const host::Layer& its : anchorsOf(group[i], task.layers))
            task.changes.showAside(its, moves[i]);
          beside.extend(boxes[i].translated(moves[i]));
        }
      }
      task.say(messages::layersSideBySide, count);
    }
    return {{"layers", count}, {"side_by_side", !allAside}};
  }

 private:
  const host::Help help_{"apply_layers_side_by_side"};
};

}  // namespace

std::unique_ptr<host::Filter> makeLayoutFilter() { return std::make_unique<LayoutFilter>(); }

}  // namespace sphere_propagation
