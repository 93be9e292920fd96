// SPDX-License-Identifier: GPL-3.0-only
// "Spherical parameterise root": the current layer gets an area-preserving map to the unit sphere.

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "filter_sphere_propagation/anchor_sources.h"
#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/largest_layer.h"
#include "filter_sphere_propagation/messages.h"
#include "filter_sphere_propagation/reporting.h"
#include "host/help.h"
#include "vcg_ext/anchors/anchor_file.h"
#include "vcg_ext/anchors/anchor_places.h"
#include "vcg_ext/mesh/sphere_fit.h"
#include "vcg_ext/root_map/placed_root_map.h"
#include "vcg_ext/root_map/root_map.h"
#include "vcg_ext/sequence/similarity_tree.h"

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
        help_.parameter("anchor_positions",
                        host::Parameter::File{
                            "Places on the sphere (*.csv *.tsv *.txt *.json *.pp);;All files (*)"}),
        help_.parameter("most_central", false).asAdvanced(),
        help_.parameter("threads", RootMapParameters{}.threads).asAdvanced()};
  }

  host::Outputs run(host::Task& task) const override {
    const Stopwatch stopwatch;
    RootMapParameters parameters;
    parameters.initialMap = task.values.choice("initial_map", initialMaps);
    parameters.areaWeight = task.values.real("area_weight");
    parameters.threads = task.values.integer("threads");
    const bool central = task.values.flag("most_central");
    const host::Layer layer =
        central ? mostCentralLayer(task, parameters.threads) : task.layers.current();
    const MeshSurface mesh = layer.surface();
    const std::string positions = task.values.file("anchor_positions");
    Places places;  // before the long work
    if (!positions.empty()) places = readPlaces(task, layer, positions);
    RootMapResult result =
        makeRootMap(mesh.surface, parameters,
                    part(task.progress, central ? 0.25 : 0, positions.empty() ? 0.95 : 0.5));
    std::optional<Eigen::VectorXd> moved;
    if (!positions.empty()) moved = place(task, places, parameters, result);
    const auto storageNote = task.changes.setMap(layer, mesh, result.map);
    if (central) task.changes.makeCurrent(layer);
    const MapMeasures measures = measureMap(mesh.surface, result.map.positions());
    if (!result.failures.empty())
      task.sayOf(layer, messages::anotherStart, nameOf(result.used), result.failures);
    if (storageNote) task.tell(*storageNote);
    const double seconds = stopwatch.seconds();
    if (const std::string note = central ? "" : largerLayer(task.layers); !note.empty())
      task.say(messages::betterRoot, layer.id(), note);
    if (const host::Message* note = sphereNote(layer, mesh.surface)) task.sayOf(layer, *note);
    task.log(describeMap(layer.label(), mesh.surface, measures) + ", " + shortNumber(seconds) +
             " s (" + nameOf(result.used) + " start, " + counted(result.levels, "level", "levels") +
             ", " + counted(result.steps, "step", "steps") + ")");
    task.say(messages::rootMade, layer.label());
    host::Outputs outputs{{"root_layer", layer.id()},
                          {"flipped_faces", static_cast<int>(measures.certificate.flippedFaces)},
                          {"area_ratio_sd", measures.areaRatioSd},
                          {"area_log_mean", measures.areaLogMean},
                          {"angle_error_mean", measures.angleErrorMean},
                          {"seconds", seconds}};
    if (moved) outputs["anchor_moved"] = *moved;
    return outputs;
  }

 private:
  /// Of the visible surfaces.
  static host::Layer mostCentralLayer(const host::Task& task, int threads) {
    const std::vector<host::Layer> layers = task.layers.visibleSurfaces();
    std::vector<ClosedSurface> surfaces;
    for (const host::Layer& layer : layers) surfaces.push_back(layer.surface().surface);
    ThreadPool pool(threads);
    const Eigen::MatrixXd distances = shapeDistances(surfaces, pool);
    const auto place = static_cast<size_t>(mostCentral(distances));
    report(task.progress, 0.25);
    task.say(messages::mostCentral, layers.size(), layers[place].label());
    return layers[place];
  }

  /// The layer's anchors and where they are to lie on the sphere.
  struct Places {
    AnchorSet anchors;  ///< those that have a place
    std::vector<std::string> names;
    std::vector<Vector3> targets;
  };

  static Places readPlaces(const host::Task& task, const host::Layer& layer,
                           const std::string& file) {
    const AnchorList wanted = readSpherePlaces(file);
    AnchorSet anchors = layer.anchors();
    if (anchors.empty()) {
      AnchorSources sources(task, AnchorFrame::World);
      anchors = sources.beside(layer);
      sources.sayWhichAsWritten();
    }
    if (!wanted.ambiguous.empty())
      task.sayOf(layer, messages::anchorsTwice, namesIn(wanted.ambiguous), file);
    Places places;
    std::vector<std::string> missing;
    for (const auto& [name, target] : wanted.anchors) {
      const auto found = anchors.find(name);
      if (found == anchors.end()) {
        missing.push_back(name);
        continue;
      }
      places.anchors.insert(*found);
      places.names.push_back(name);
      places.targets.push_back(target);
    }
    if (places.names.empty()) throw host::Refusal(messages::noAnchorsToPlace, layer.label(), file);
    if (!missing.empty()) task.sayOf(layer, messages::placesWithoutAnchor, namesIn(missing), file);
    warnOfFarAnchors(task, layer, places.anchors);
    return places;
  }

  /// Moves the map. Returns by how many degrees each anchor went.
  static Eigen::VectorXd place(const host::Task& task, const Places& places,
                               const RootMapParameters& parameters, RootMapResult& result) {
    const ClosedSurface& surface = result.map.surface();
    const std::vector<SurfacePoint> points = closestPoints(
        SurfaceLocator(surface.vertices(), surface.faces()), places.anchors, places.names);
    ThreadPool pool(parameters.threads);
    PlacedRootMap placed =
        placeAnchors(result.map, points, places.targets, places.names, parameters.areaWeight,
                     part(task.progress, 0.5, 0.95), &pool);
    Eigen::VectorXd moved(static_cast<Eigen::Index>(points.size()));
    for (size_t k = 0; k < points.size(); ++k) {
      const Vector3 from = placeOf(result.map, points[k]), to = places.targets[k];
      moved[static_cast<Eigen::Index>(k)] =
          std::atan2(from.cross(to).norm(), from.dot(to)) * 180 / pi;
    }
    task.say(messages::anchorsPlaced, points.size(), placed.turn * 180 / pi,
             placed.longestWay * 180 / pi);
    result.map = std::move(placed.map);
    return moved;
  }

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
