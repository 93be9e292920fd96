// SPDX-License-Identifier: GPL-3.0-only
// "Spherical parameterise root": the current layer gets an area-preserving map to the unit sphere.

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/largest_layer.h"
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
    const std::string storageNote = task.changes.setMap(layer, mesh, result.map);
    const MapMeasures measures = measureMap(mesh.surface, result.map.positions());
    if (!result.note.empty()) task.log(result.note);
    if (!storageNote.empty()) task.log(storageNote);
    const double seconds = stopwatch.seconds();
    if (const std::string note = sizeNote(task.layers); !note.empty())
      task.log("Note: " + note + ".");
    if (const std::string note = sphereNote(layer, mesh.surface); !note.empty()) task.log(note);
    task.log(describeMap(layer.label(), mesh.surface, measures) + ", " + shortNumber(seconds) +
             " s (" + nameOf(result.used) + " start, " + counted(result.levels, "level", "levels") +
             ", " + counted(result.steps, "step", "steps") + ")");
    return {{"flipped_faces", static_cast<int>(measures.certificate.flippedFaces)},
            {"area_ratio_sd", measures.areaRatioSd},
            {"area_log_mean", measures.areaLogMean},
            {"angle_error_mean", measures.angleErrorMean},
            {"seconds", seconds}};
  }

 private:
  /// A sphere looks the same from all sides.
  static std::string sphereNote(const host::Layer& layer, const ClosedSurface& surface) {
    constexpr double round = 1e-4;
    if (layer.kind() == host::LayerKind::Sphere)
      return "Note: layer \"" + layer.label() +
             "\" lies on the unit sphere, so the other filters take it for one that \"Show "
             "parameterisation as sphere layers\" made, and leave it out. Where it is a surface, "
             "scale it.";
    if (deviationFromSphere(surface.vertices()) > round) return {};
    return "Note: layer \"" + layer.label() +
           "\" is itself a sphere: any rotation of its map is as good, and nothing tells how other "
           "spheres are to be turned to match it.";
  }

  static std::string sizeNote(const host::Layers& layers) {
    const int current = layers.currentId();
    const std::string note = LargestLayer(layers.visible(host::LayerKind::Surface)).note(current);
    return note.empty()
               ? note
               : "the current layer is " + std::to_string(current) + "; for a heart cycle, " + note;
  }

  const host::Help help_{"compute_spherical_parameterisation_root"};
};

}  // namespace

std::unique_ptr<host::Filter> makeRootFilter() { return std::make_unique<RootFilter>(); }

}  // namespace sphere_propagation
