// "Show parameterisation as sphere layers": the maps, to be looked at.

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/mapped_layers.h"
#include "filter_sphere_propagation/reporting.h"

namespace sphere_propagation {
namespace {

class SphereLayersFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return {
        "Show parameterisation as sphere layers", "generate_sphere_layers",
        "Makes a new layer \"... sphere\" of every visible surface layer that has a map: the surface's own triangles "
        "on the unit sphere, with its colours. Run again, the filter replaces the layers that it made.<br><br>"
        "Returned: <b>layers</b>: how many were made.<br><br>" +
            paperReference(),
        static_cast<int>(host::Menu::Layer), host::Arity::VisibleLayers};
  }

  std::vector<host::Parameter> parameters(const host::Layers&) const override { return {}; }

  host::Outputs run(host::Task& task) const override {
    const std::vector<MappedLayer> layers = mappedLayers(task);
    for (size_t i = 0; i < layers.size(); ++i) {
      const auto& [layer, mesh, map] = layers[i];
      host::NewLayer sphere;
      sphere.label = layer.derivedLabel("sphere");
      sphere.kind = host::LayerKind::Sphere;
      sphere.vertices = map.positions();
      sphere.faces = mesh.surface.faces();
      sphere.colors = layer.colors(mesh);
      task.changes.addLayer(sphere);
      report(task.progress, static_cast<double>(i + 1) / static_cast<double>(layers.size()));
    }
    const int made = static_cast<int>(layers.size());
    task.log(counted(made, "sphere layer", "sphere layers"));
    return {{"layers", made}};
  }
};

}  // namespace

std::unique_ptr<host::Filter> makeSphereLayersFilter() { return std::make_unique<SphereLayersFilter>(); }

}  // namespace sphere_propagation
