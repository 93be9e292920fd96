// SPDX-License-Identifier: GPL-3.0-only
// "Spherical parameterise root": the current layer gets an area-preserving map to the unit sphere.

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/largest_layer.h"
#include "filter_sphere_propagation/messages.h"
#include "filter_sphere_propagation/reporting.h"
#include "host/help.h"
#include "vcg_ext/mesh/sphere_fit.h"
#include "vcg_ext/root_map/root_map.h"

namespace sphere_propagation {
namespace {

constexpr host::Named<InitialMap> initialMaps[]{{"Automatic", InitialMap::Automatic},
                                                {"Brechbuehler", InitialMap::Brechbuehler},
                                                {"Harmonic", InitialMap::Harmonic}};

class RootFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return help_.describe(host::Menu::Remeshing | host::Menu::Layer, host::Arity::CurrentLayer);
  }

  std::vector<host::Parameter> parameters(const host::Layers& layers) const override {
    return {
        help_.parameter("initial_map", host::choiceOf(initialMaps, RootMapParameters{}.initialMap))
            .withNote(sizeNote(layers)),
        help_.parameter("area_weight", RootMapParameters{}.areaWeight),
        help_.parameter("threads", RootMapParameters{}.threads).asAdvanced()};
  }

  host::Outputs run(host::Task& task) const override {
    const Stopwatch stopwatch;
    RootMapParameters parameters;
    parameters.initialMap = task.values.choice("initial_map", initialMaps);
    parameters.areaWeight = task.values.real("area_weight");
    parameters.threads = task.values.integer("threads");
    const host::Layer layer = task.layers.current();
    const MeshSurface mesh = layer.surface();
    const RootMapResult result =
        makeRootMap(mesh.surface, parameters, part(task.progress, 0, 0.95));
    const auto storageNote = task.changes.setMap(layer, mesh, result.map);
    const MapMeasures measures = measureMap(mesh.surface, result.map.positions());
    if (!result.failures.empty())
      task.sayOf(layer, messages::anotherStart, nameOf(result.used), result.failures);
    if (storageNote) task.tell(*storageNote);
    const double seconds = stopwatch.seconds();
    if (const std::string note = largerLayer(task.layers); !note.empty())
      task.say(messages::betterRoot, layer.id(), note);
    if (const host::Message* note = sphereNote(layer, mesh.surface)) task.sayOf(layer, *note);
    task.log(describeMap(layer.label(), mesh.surface, measures) + ", " + shortNumber(seconds) +
             " s (" + nameOf(result.used) + " start, " + counted(result.levels, "level", "levels") +
             ", " + counted(result.steps, "step", "steps") + ")");
    task.say(messages::rootMade, layer.label());
    return {{"flipped_faces", static_cast<int>(measures.certificate.flippedFaces)},
            {"area_ratio_sd", measures.areaRatioSd},
            {"area_log_mean", measures.areaLogMean},
            {"angle_error_mean", measures.angleErrorMean},
            {"seconds", seconds}};
  }

 private:
  /// A sphere looks the same from all sides.
  static const host::Message* sphereNote(const host::Layer& layer, const ClosedSurface& surface) {
    constexpr double round = 1e-4;
    if (layer.kind() == host::LayerKind::Sphere) return &messages::rootOnUnitSphere;
    return deviationFromSphere(surface.vertices()) > round ? nullptr : &messages::rootIsSphere;
  }

  static std::string largerLayer(const host::Layers& layers) {
    return LargestLayer(layers.visible(host::LayerKind::Surface)).note(layers.currentId());
  }

  static std::string sizeNote(const host::Layers& layers) {
    const std::string note = largerLayer(layers);
    return note.empty() ? note : host::said(messages::betterRoot, layers.currentId(), note);
  }

  const host::Help help_{"compute_spherical_parameterisation_root"};
};

}  // namespace

std::unique_ptr<host::Filter> makeRootFilter() { return std::make_unique<RootFilter>(); }

}  // namespace sphere_propagation
