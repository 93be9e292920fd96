// SPDX-License-Identifier: GPL-3.0-only
// "Evaluate spherical parameterisation": figures of the maps that layers carry.

#include <utility>

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/map_roots.h"
#include "filter_sphere_propagation/mapped_layers.h"
#include "filter_sphere_propagation/messages.h"
#include "filter_sphere_propagation/reporting.h"
#include "filter_sphere_propagation/summaries.h"
#include "host/help.h"

namespace sphere_propagation {
namespace {

class EvaluationFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return help_.describe(host::Menu::Measure | host::Menu::Layer, host::Arity::VisibleLayers);
  }

  std::vector<host::Parameter> parameters(const host::Layers&) const override { return {}; }

  host::Outputs run(host::Task& task) const override {
    std::vector<host::Layer> layers;
    std::vector<MeshSurface> meshes;
    for (const host::Layer& layer : task.layers.visibleSurfaces())
      if (auto mesh = surfaceWithPositions(task, layer)) {
        layers.push_back(layer);
        meshes.push_back(std::move(*mesh));
      }
    if (layers.empty()) throw host::Refusal(messages::nothingToEvaluate);
    MapFigures figures(layers.size());
    const auto count = static_cast<Eigen::Index>(layers.size());
    Eigen::VectorXd valid(count), degree(count), root(count);
    for (size_t i = 0; i < layers.size(); ++i) {
      const Stopwatch stopwatch;
      const MeshSurface& mesh = meshes[i];
      const MapMeasures measures = measureMap(mesh.surface, *layers[i].storedPositions(mesh));
      const double seconds = stopwatch.seconds();
      figures.set(i, measures, seconds);
      valid[static_cast<Eigen::Index>(i)] = measures.certificate.valid() ? 1 : 0;
      degree[static_cast<Eigen::Index>(i)] = measures.certificate.degree;
      const std::optional<int> rootMark = layers[i].mark(host::rootMark);
      root[static_cast<Eigen::Index>(i)] = rootMark.value_or(-1);
      task.log(describeMap(layers[i].label(), mesh.surface, measures) +
               (rootMark ? ", root " + std::to_string(*rootMark) : std::string()) + ", " +
               shortNumber(seconds) + " s");
      if (!measures.certificate.valid())
        task.sayOf(layers[i], messages::mapNotValid, measures.certificate.reason());
      report(task.progress, static_cast<double>(i + 1) / static_cast<double>(count));
    }
    logSeveralRoots(task, layers);
    const auto mapped = static_cast<size_t>(valid.sum());
    task.say(messages::mapsEvaluated, task.layers.visible(host::LayerKind::Surface).size(), mapped,
             hiddenLeftOut(task.layers, host::LayerKind::Surface), nextFilter(task.layers, mapped));
    host::Outputs outputs = {{"valid", valid}, {"degree", degree}, {"root", root}};
    figures.addTo(outputs);
    return outputs;
  }

 private:
  const host::Help help_{"get_spherical_parameterisation_measures"};
};

}  // namespace

std::unique_ptr<host::Filter> makeEvaluationFilter() {
  return std::make_unique<EvaluationFilter>();
}

}  // namespace sphere_propagation
