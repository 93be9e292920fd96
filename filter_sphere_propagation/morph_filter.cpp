// SPDX-License-Identifier: GPL-3.0-only
// "Morph between layers": shapes between those that are there.

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/mapped_layers.h"
#include "filter_sphere_propagation/messages.h"
#include "filter_sphere_propagation/reporting.h"
#include "filter_sphere_propagation/summaries.h"
#include "host/help.h"
#include "host/window.h"
#include "vcg_ext/display/side_by_side.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/morphing/morph.h"

namespace sphere_propagation {
namespace {

constexpr host::Named<MorphConnectivity> connectivities[]{
    {"Common icosphere", MorphConnectivity::Icosphere},
    {"Union of both connectivities", MorphConnectivity::Union}};
constexpr host::Named<MorphPath> morphPaths[]{{"Linear", MorphPath::Linear},
                                              {"Shape model", MorphPath::ShapeModel}};

/// Of what the smaller of two surfaces encloses; a shape between them that encloses less is named.
constexpr double leastVolume = 0.8;

double volumeOf(const MappedLayer& layer) {
  const ClosedSurface& surface = layer.map.surface();
  return enclosedVolume(surface.vertices(), surface.faces());
}

class MorphFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return help_.describe(host::Menu::Layer, host::Arity::VisibleLayers);
  }

  std::vector<host::Parameter> parameters(const host::Layers&) const override {
    const MorphParameters defaults;
    return {help_.parameter("steps", defaults.steps),
            help_.parameter("connectivity", host::choiceOf(connectivities, defaults.connectivity)),
            help_.parameter("frequency", defaults.frequency),
            help_.parameter("along", host::choiceOf(morphPaths, defaults.path)),
            help_.parameter("closed", defaults.closed),
            help_.parameter("ends", defaults.ends),
            help_.parameter("beside_surfaces", host::hasWindow()),
            help_.parameter("threads", defaults.threads).asAdvanced()};
  }

  host::Outputs run(host::Task& task) const override {
    const Stopwatch stopwatch;
    MorphParameters parameters;
    parameters.steps = task.values.integer("steps");
    parameters.connectivity = task.values.choice("connectivity", connectivities);
    parameters.frequency = task.values.integer("frequency");
    parameters.path = task.values.choice("along", morphPaths);
    parameters.closed = task.values.flag("closed");
    parameters.ends = task.values.flag("ends");
    parameters.threads = task.values.integer("threads");
    requireRange("number of threads", parameters.threads, Range::atLeast(0));
    ThreadPool pool(parameters.threads);
    const std::vector<MappedLayer> layers = mappedLayers(task, &pool);
    if (layers.size() < 2)
      throw host::Refusal(messages::onlyMappedLayer, layers.front().layer.label());
    std::vector<MappedSurface> surfaces;
    for (const MappedLayer& layer : layers) surfaces.push_back(layer.map);
    const Morph morph = makeMorph(surfaces, parameters, part(task.progress, 0, 0.9));
    requireAll(layers, morph);
    warnOfLostVolume(task, layers, morph);
    addLayers(task, layers, morph);
    task.say(messages::morphMade, layers.size(), morph.shapes.size(),
             hiddenLeftOut(task.layers, host::LayerKind::Surface));
    host::Outputs outputs = outputsOf(layers, morph);
    outputs["seconds"] = stopwatch.seconds();
    return outputs;
  }

 private:
  static void requireAll(const std::vector<MappedLayer>& layers, const Morph& morph) {
    const auto label = [&](size_t i) { return layers[i % layers.size()].layer.label(); };
    for (size_t pair = 0; pair < morph.crossings.size(); ++pair)
      if (!morph.crossings[pair])
        throw host::Refusal(messages::mapsHaveNoUnion, label(pair), label(pair + 1));
    for (const MorphShape& shape : morph.shapes)
      if (!shape.map)
        throw host::Refusal(messages::morphCollapses, label(shape.from), label(shape.to),
                            100 * shape.share);
  }

  static void warnOfLostVolume(const host::Task& task, const std::vector<MappedLayer>& layers,
                               const Morph& morph) {
    std::vector<double> volumes;
    for (const MappedLayer& layer : layers) volumes.push_back(volumeOf(layer));
    for (size_t i = 0; i < morph.shapes.size();) {
      const size_t from = morph.shapes[i].from, to = morph.shapes[i].to;
      double least = 1;
      for (; i < morph.shapes.size() && morph.shapes[i].from == from; ++i)
        least = std::min(least, morph.shapes[i].volume / std::min(volumes[from], volumes[to]));
      if (least >= leastVolume) continue;
      const std::string first = layers[from].layer.label(), second = layers[to].layer.label();
      task.sayNaming({first, second}, messages::morphLosesVolume, first, second, 100 * least);
    }
  }

  static void addLayers(host::Task& task, const std::vector<MappedLayer>& layers,
                        const Morph& morph) {
    const bool beside = task.values.flag("beside_surfaces");
    std::vector<Eigen::AlignedBox3d> boxes;
    for (const MorphShape& shape : morph.shapes)
      boxes.push_back(boxOf(shape.map->surface().vertices()));
    const std::vector<Vector3> moves =
        sideBySide(boxes, shownBeside(task.layers, host::LayerKind::Morph));
    for (size_t i = 0; i < morph.shapes.size(); ++i) {
      const MorphShape& shape = morph.shapes[i];
      host::NewLayer made;
      made.label = nameOfMorph(layers[shape.from].layer.plainLabel(),
                               layers[shape.to].layer.plainLabel(), shape.share);
      made.kind = host::LayerKind::Morph;
      made.vertices = shape.map->surface().vertices();
      made.faces = shape.map->faces();
      made.pointAttributes[host::spherePositionAttribute] = shape.map->positions();
      if (beside) made.aside = moves[i];
      task.changes.addLayer(made);
    }
    task.changes.removeOtherLayers(host::LayerKind::Morph);
    if (host::hasWindow()) task.changes.makeFirstNewLayerCurrent();
    if (beside) task.say(messages::shownAside);
  }

  static host::Outputs outputsOf(const std::vector<MappedLayer>& layers, const Morph& morph) {
    const auto count = static_cast<Eigen::Index>(morph.shapes.size());
    Eigen::VectorXd from(count), to(count), share(count), volume(count), vertices(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const MorphShape& shape = morph.shapes[static_cast<size_t>(i)];
      from[i] = layers[shape.from].layer.id();
      to[i] = layers[shape.to].layer.id();
      share[i] = shape.share;
      volume[i] = shape.volume;
      vertices[i] = shape.map->vertexCount();
    }
    long crossings = 0;
    for (const std::optional<int>& ofPair : morph.crossings) crossings += ofPair.value_or(0);
    return {{"layers", static_cast<int>(count)},
            {"from", from},
            {"to", to},
            {"share", share},
            {"volume", volume},
            {"vertices", vertices},
            {"crossings", static_cast<int>(crossings)}};
  }

  const host::Help help_{"generate_morph",
                         {{"max_frequency", std::to_string(maxIcosphereFrequency)}}};
};

}  // namespace

std::unique_ptr<host::Filter> makeMorphFilter() { return std::make_unique<MorphFilter>(); }

}  // namespace sphere_propagation
