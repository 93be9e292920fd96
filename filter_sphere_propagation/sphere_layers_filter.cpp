// "Show parameterisation as sphere layers": the maps, to be looked at.

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/reporting.h"

namespace sphere_propagation {
namespace {

class SphereLayersFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return {"Show parameterisation as sphere layers", "generate_sphere_layers",
            "Makes a new layer \"... sphere\" of every visible surface layer that has a map: the surface's own triangles "
            "on the unit sphere, with its colours. Run again, the filter replaces the layers that it made.<br><br>"
            "Returned: <b>layers</b>: how many were made.<br><br>" +
                paperReference(),
            static_cast<int>(host::Menu::Layer), host::Arity::VisibleLayers};
  }

  std::vector<host::Parameter> parameters(const host::Layers&) const override { return {}; }

  host::Outputs run(host::Task& task) const override {
    const std::vector<host::Layer> layers = task.layers.visibleSurfaces();
    int made = 0;
    for (size_t i = 0; i < layers.size(); ++i) {
      report(task.progress, static_cast<double>(i) / static_cast<double>(layers.size()));
      if (!layers[i].storesPositions()) continue;
      const MeshSurface mesh = layers[i].surface();
      const std::optional<SphereMap> map = layers[i].map(mesh);
      if (!map) {
        task.log(layers[i].label() + ": carries no valid map, left out");
        continue;
      }
      host::NewLayer sphere;
      sphere.label = layers[i].derivedLabel("sphere");
      sphere.kind = host::LayerKind::Sphere;
      sphere.vertices = map->positions();
      sphere.faces = mesh.surface.faces();
      sphere.colors = layers[i].colors(mesh);
      task.changes.addLayer(sphere);
      ++made;
    }
    if (made == 0)
      throw MapError(0, -1,
                     "No visible surface layer has a map to the sphere. Run \"Spherical parameterise root\" on one first.");
    task.log(counted(made, "sphere layer", "sphere layers"));
    return {{"layers", made}};
  }
};

}  // namespace

std::unique_ptr<host::Filter> makeSphereLayersFilter() { return std::make_unique<SphereLayersFilter>(); }

}  // namespace sphere_propagation
