// SPDX-License-Identifier: GPL-3.0-only
// "Colour by spherical parameterisation": the same place has the same colour on every layer.

#include <utility>

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/mapped_layers.h"
#include "filter_sphere_propagation/reporting.h"
#include "vcg_ext/display/sphere_pattern.h"
#include "vcg_ext/mesh/icosphere.h"

namespace sphere_propagation {
namespace {

constexpr int areaRatioPattern = 3;  // behind those of SpherePattern

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
    return {
        "Colour by spherical parameterisation",
        "compute_color_from_spherical_parameterisation_per_vertex",
        "Draws a pattern of the unit sphere on the vertices of every visible layer that has a "
        "place on it: surfaces with a map, their sphere layers, and landmark layers. <b>The same "
        "place has the same colour on every layer</b>, so a look at several phases shows whether a "
        "map is right.<br><br><b>Checkerboard</b>: fields between meridians and parallels; the hue "
        "turns with the longitude, the north pole is light and the south pole dark. <b>Latitude "
        "and longitude</b>: meridians and parallels as stripes on white, the 0 meridian and the "
        "equator in black. <b>Direction</b>: hue and lightness alone. These need some ten vertices "
        "per field; edges are blended over the distance of the vertices.<br><b>Area ratio</b>: "
        "share of the sphere / share of the surface. Light grey: 1, areas are preserved; red: too "
        "much of the sphere; blue: too little. It is also stored as quality of vertices and faces, "
        "so that MeshLab's colour ramps, histograms and selections work on it.<br><br>Returned: "
        "<b>layers</b>: how many were coloured.<br><br>" +
            paperReference() +
            "Blended edges:<br><i>Inigo Quilez</i><br><b>\"Filtering the checkerboard "
            "pattern\"</b><br>2008.<br>Colours of ratios:<br><i>Kenneth "
            "Moreland</i><br><b>\"Diverging color maps for scientific "
            "visualization\"</b><br>International Symposium on Visual Computing, 2009.",
        host::Menu::VertexColoring | host::Menu::Quality, host::Arity::VisibleLayers};
  }

  std::vector<host::Parameter> parameters(const host::Layers&) const override {
    return {{"pattern", "Pattern", "What is drawn on the sphere; see above.",
             host::Parameter::Choice{
                 {"Checkerboard", "Latitude and longitude", "Direction", "Area ratio"}, 0}},
            {"cells", "Cells",
             "Fields from pole to pole, 2 to " + std::to_string(maxPatternCells) +
                 "; half as many again round the equator. For the checkerboard, and latitude and "
                 "longitude.",
             SpherePatternParameters{}.cells},
            {"area_ratio_limit", "Area ratio at full colour",
             "Greater than 1. With 2, the colours of the area ratio end at twice (red) and half "
             "(blue) of the area's due share.",
             2.0},
            {"store_area_ratio", "Store area ratio as quality",
             "Store the area ratio as quality of vertices and faces with every pattern, in place "
             "of what quality the layers have. The pattern \"Area ratio\" always does.",
             false},
            {"landmark_layers", "Landmark layers too",
             "Colour landmark layers as well, in place of the colours of their landmarks' numbers, "
             "which \"Remesh by icosphere\" brings back.",
             true}};
  }

  host::Outputs run(host::Task& task) const override {
    const int pattern = task.values.choice("pattern");
    const double limit = task.values.real("area_ratio_limit");
    SpherePatternParameters parameters;
    parameters.cells = task.values.integer("cells");
    if (pattern != areaRatioPattern) parameters.pattern = static_cast<SpherePattern>(pattern);
    const bool storeRatio = pattern == areaRatioPattern || task.values.flag("store_area_ratio");

    const std::vector<PlacedLayer> layers = placedLayers(task, task.values.flag("landmark_layers"));
    int colored = 0;
    for (size_t i = 0; i < layers.size(); ++i) {
      const auto& [layer, mesh, positions, source] = layers[i];
      if (source != nullptr && storeRatio) {
        const Eigen::VectorXd ratios = vertexAreaRatios(*source, positions);
        task.changes.setQuality(layer, mesh, ratios, areaRatios(*source, positions));
        task.log(layer.label() + ": area ratio " + shortNumber(ratios.minCoeff()) + " to " +
                 shortNumber(ratios.maxCoeff()));
        if (pattern == areaRatioPattern)
          task.changes.setColors(layer, mesh, areaRatioColors(ratios, limit));
      }
      if (pattern != areaRatioPattern)
        task.changes.setColors(
            layer, mesh,
            sphereColors(positions, sphereSpacing(positions, mesh.surface.faces()), parameters));
      if (source == nullptr && storeRatio)
        task.log(layer.label() +
                 ": the surface of this sphere is not visible, so it has no area ratio");
      if (source != nullptr || pattern != areaRatioPattern) ++colored;
      report(task.progress, static_cast<double>(i + 1) / static_cast<double>(layers.size()));
    }
    if (colored == 0)
      throw MapError(0, -1,
                     "The visible sphere layers alone have no area ratio: show the surfaces that "
                     "they were made of.");
    task.log(counted(colored, "layer", "layers") + " coloured");
    return {{"layers", colored}};
  }

 private:
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
    if (found.empty())
      throw MapError(0, -1,
                     "No visible layer has places on the sphere to be coloured by. Run \"Spherical "
                     "parameterise root\" on a surface first, and \"Propagate parameterisation to "
                     "layers\" for the others.");
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
      task.log(std::string(error.what()) + " The layer is left out.");
      return std::nullopt;
    }
  }
};

}  // namespace

std::unique_ptr<host::Filter> makeColorFilter() { return std::make_unique<ColorFilter>(); }

}  // namespace sphere_propagation
