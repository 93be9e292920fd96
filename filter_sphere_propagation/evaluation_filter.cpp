// SPDX-License-Identifier: GPL-3.0-only
// "Evaluate spherical parameterisation": figures of the maps that layers carry.

#include <utility>

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/map_roots.h"
#include "filter_sphere_propagation/mapped_layers.h"
#include "filter_sphere_propagation/reporting.h"

namespace sphere_propagation {
namespace {

class EvaluationFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return {"Evaluate spherical parameterisation", "get_spherical_parameterisation_measures",
            "Certifies and measures the map to the unit sphere of every visible surface layer that "
            "carries one, as attribute <i>sphere_position</i> or, where there is none, as texture "
            "coordinates. A map that is not valid is reported, not refused. Nothing is "
            "changed.<br><br>Returned, one entry per layer that carries a map: <b>valid</b>: 1 or "
            "0; <b>degree</b>: how often the sphere is covered, 1 in a valid map; <b>root</b>: a "
            "number that stands for the root that the map came from, the same on all layers whose "
            "maps belong together, -1 where it is not known, as of maps read from files; " +
                mapFiguresInfo() +
                "<br><br>Orientation is decided exactly:<br><i>Jonathan Richard "
                "Shewchuk</i><br><b>\"Adaptive precision floating-point arithmetic and fast robust "
                "geometric predicates\"</b><br>Discrete &amp; Computational Geometry 18, "
                "1997.<br>Areas on the sphere:<br><i>Adriaan van Oosterom and Jan "
                "Strackee</i><br><b>\"The solid angle of a plane triangle\"</b><br>IEEE "
                "Transactions on Biomedical Engineering 30(2), 1983.",
            static_cast<int>(host::Menu::Measure), host::Arity::VisibleLayers};
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
    if (layers.empty())
      throw MapError(0, -1,
                     "No visible surface layer carries a map to the sphere. Run \"Spherical "
                     "parameterise root\" on one first.");
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
      report(task.progress, static_cast<double>(i + 1) / static_cast<double>(count));
    }
    logSeveralRoots(task, layers);
    host::Outputs outputs = {{"valid", valid}, {"degree", degree}, {"root", root}};
    figures.addTo(outputs);
    return outputs;
  }
};

}  // namespace

std::unique_ptr<host::Filter> makeEvaluationFilter() {
  return std::make_unique<EvaluationFilter>();
}

}  // namespace sphere_propagation
