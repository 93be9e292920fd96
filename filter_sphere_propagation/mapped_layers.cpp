#include "filter_sphere_propagation/mapped_layers.h"

#include <utility>

namespace sphere_propagation {

std::optional<MeshSurface> surfaceWithPositions(const host::Task& task, const host::Layer& layer) {
  if (!layer.storesPositions()) {
    task.log(layer.label() + ": has no map, left out");
    return std::nullopt;
  }
  try {
    return layer.surface();
  } catch (const SurfaceError& error) {
    if (layer.hasAttribute()) throw;
    task.log(layer.label() + ": has no map, left out (" + error.what() + ")");
    return std::nullopt;
  }
}

std::vector<MappedLayer> mappedLayersIfAny(const host::Task& task) {
  std::vector<MappedLayer> found;
  for (const host::Layer& layer : task.layers.visible(host::LayerKind::Surface)) {
    std::optional<MeshSurface> mesh = surfaceWithPositions(task, layer);
    if (!mesh) continue;
    std::optional<SphereMap> map = layer.map(*mesh);
    if (map)
      found.push_back({layer, std::move(*mesh), std::move(*map)});
    else
      task.log(layer.label() + ": carries no valid map, left out");
  }
  return found;
}

std::vector<MappedLayer> mappedLayers(const host::Task& task) {
  task.layers.visibleSurfaces();  // says so where there is none
  std::vector<MappedLayer> found = mappedLayersIfAny(task);
  if (found.empty())
    throw MapError(
        0, -1,
        "No visible surface layer has a map to the sphere. Run \"Spherical parameterise root\" on one first, and "
        "\"Propagate parameterisation to layers\" for the others.");
  return found;
}

}  // namespace sphere_propagation
