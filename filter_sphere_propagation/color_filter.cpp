// SPDX-License-Identifier: GPL-3.0-only
// "Colour by spherical parameterisation": the same place has the same colour on every layer.

#include <algorithm>
#include <optional>
#include <utility>

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/mapped_layers.h"
#include "filter_sphere_propagation/messages.h"
#include "filter_sphere_propagation/reporting.h"
#include "filter_sphere_propagation/summaries.h"
#include "host/help.h"
#include "host/remedies.h"
#include "vcg_ext/display/sphere_pattern.h"
#include "vcg_ext/mesh/icosphere.h"

namespace sphere_propagation {
namespace {

/// What is drawn; nothing: the area ratio.
using Pattern = std::optional<SpherePattern>;
constexpr host::Named<Pattern> patterns[]{{"Checkerboard", SpherePattern::Checkerboard},
                                          {"Latitude and longitude", SpherePattern::Graticule},
                                          {"Direction", SpherePattern::Direction},
                                          {"Area ratio", std::nullopt}};

/// A layer whose vertices have places on the sphere.
struct PlacedLayer {
  host::Layer layer;
  MeshSurface mesh;
  Points positions;
  /// The surface whose map this is; itself but for sphere layers, and none for a sphere whose
  /// surface is not seen.
  const ClosedSurface* source = nullptr;
};

class ColorFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return help_.describe(host::Menu::VertexColoring | host::Menu::Quality | host::Menu::Layer,
                          host::Arity::VisibleLayers);
  }

  std::vector<host::Parameter> parameters(const host::Layers& layers) const override {
    return {help_.parameter("pattern",
                            host::choiceOf(patterns, Pattern(SpherePatternParameters{}.pattern))),
            help_.parameter("cells", visibleCells(layers)),
            help_.parameter("area_ratio_limit", 2.0), help_.parameter("store_area_ratio", false),
            help_.parameter("landmark_layers", true)};
  }

  host::Outputs run(host::Task& task) const override {
    const Pattern pattern = task.values.choice("pattern", patterns);
    const double limit = task.values.real("area_ratio_limit");
    SpherePatternParameters parameters;
    parameters.cells = task.values.integer("cells");
    if (pattern) parameters.pattern = *pattern;
    const bool storeRatio = !pattern || task.values.flag("store_area_ratio");

    const bool withLandmarks = task.values.flag("landmark_layers");
    const std::vector<PlacedLayer> layers = placedLayers(task, withLandmarks);
    int colored = 0;
    for (size_t i = 0; i < layers.size(); ++i) {
      const auto& [layer, mesh, positions, source] = layers[i];
      if (source != nullptr && storeRatio) {
        const Eigen::VectorXd ratios = vertexAreaRatios(*source, positions);
        task.changes.setQuality(layer, mesh, ratios, areaRatios(*source, positions));
        task.log(layer.label() + ": area ratio " + shortNumber(ratios.minCoeff()) + " to " +
                 shortNumber(ratios.maxCoeff()));
        if (!pattern) task.changes.setColors(layer, mesh, areaRatioColors(ratios, limit));
      }
      if (pattern)
        task.changes.setColors(
            layer, mesh,
            sphereColors(positions, sphereSpacing(positions, mesh.surface.faces()), parameters));
      if (source == nullptr && storeRatio) task.sayOf(layer, messages::sphereWithoutSurface);
      if (source != nullptr || pattern) ++colored;
      report(task.progress, static_cast<double>(i + 1) / static_cast<double>(layers.size()));
    }
    if (colored == 0) throw host::Refusal(messages::spheresAlone);
    std::vector<host::LayerKind> kinds{host::LayerKind::Surface, host::LayerKind::Sphere};
    if (withLandmarks) kinds.push_back(host::LayerKind::Landmarks);
    const auto mapped = std::count_if(layers.begin(), layers.end(), [](const PlacedLayer& placed) {
      return placed.layer.kind() == host::LayerKind::Surface;
    });
    task.say(messages::layersColoured, colored, hiddenLeftOut(task.layers, kinds),
             nextFilter(task.layers, static_cast<size_t>(mapped)));
    return {{"layers", colored}};
  }

 private:
  /// Fields that all meshes with a map can show: what is too fine for the coarsest of them is a
  /// smear.
  static int visibleCells(const host::Layers& layers) {
    int least = 0;
    for (const host::Layer& layer : layers.visible(host::LayerKind::Surface))
      if (layer.storesPositions() && (least == 0 || layer.vertexCount() < least))
        least = layer.vertexCount();
    return least > 0 ? cellsFor(least) : SpherePatternParameters{}.cells;
  }

  /// In the order surfaces, spheres, landmarks.
  static std::vector<PlacedLayer> placedLayers(const host::Task& task, bool withLandmarks) {
    std::vector<PlacedLayer> found;
    for (MappedLayer& mapped : mappedLayersIfAny(task))
      found.push_back({mapped.layer, std::move(mapped.mesh), mapped.map.positions()});
    const size_t surfaces = found.size();
    for (const host::Layer& layer : task.layers.visible(host::LayerKind::Sphere))
      if (auto mesh = surfaceOrLog(task, layer)) {
        Points positions = layer.storedVertices(*mesh);
        found.push_back({layer, std::move(*mesh), std::move(positions)});
      }
    const size_t spheres = found.size();
    if (withLandmarks)
      for (const host::Layer& layer : task.layers.visible(host::LayerKind::Landmarks)) {
        const std::optional<int> frequency = layer.icosphereFrequency();
        auto mesh = frequency ? surfaceOrLog(task, layer) : std::nullopt;
        if (mesh) found.push_back({layer, std::move(*mesh), icosphere(*frequency).vertices});
      }
    if (found.empty()) throw host::Refusal(messages::nothingToColour);
    for (size_t i = 0; i < found.size(); ++i)
      found[i].source = i < surfaces || i >= spheres ? &found[i].mesh.surface
                                                     : sourceOf(found[i], found, surfaces);
    return found;
  }

  /// The surface whose map a sphere layer shows: same faces, same positions (texture coordinates
  /// and the host's precision round them).
  static const ClosedSurface* sourceOf(const PlacedLayer& sphere,
                                       const std::vector<PlacedLayer>& layers, size_t surfaces) {
    constexpr double rounding = 1e-5;
    for (size_t i = 0; i < surfaces; ++i)
      if (layers[i].positions.rows() == sphere.positions.rows() &&
          layers[i].mesh.surface.faceCount() == sphere.mesh.surface.faceCount() &&
          layers[i].mesh.surface.faces() == sphere.mesh.surface.faces() &&
          (layers[i].positions - sphere.positions).cwiseAbs().maxCoeff() <= rounding)
        return &layers[i].mesh.surface;
    return nullptr;
  }

  static std::optional<MeshSurface> surfaceOrLog(const host::Task& task, const host::Layer& layer) {
    try {
      return layer.surface();
    } catch (const SurfaceError& error) {
      task.sayOf(layer, messages::layerLeftOut, host::complaint(error));
      return std::nullopt;
    }
  }

  const host::Help help_{"compute_color_from_spherical_parameterisation_per_vertex",
                         {{"max_cells", std::to_string(maxPatternCells)}}};
};

}  // namespace

std::unique_ptr<host::Filter> makeColorFilter() { return std::make_unique<ColorFilter>(); }

}  // namespace sphere_propagation
