// SPDX-License-Identifier: GPL-3.0-only
#include "filter_sphere_propagation/mapped_layers.h"

#include <utility>

#include "filter_sphere_propagation/map_roots.h"
#include "filter_sphere_propagation/messages.h"
#include "host/remedies.h"

namespace sphere_propagation {

namespace {

/// What a layer was read as, and what is to be said about it.
struct Reading {
  std::optional<MeshSurface> mesh;
  std::optional<MappedSurface> map;
  std::optional<host::Remark> note;
};

Reading readSurface(const host::Layer& layer) {
  if (!layer.storesPositions())
    return {std::nullopt, std::nullopt, host::remarkOn(layer.label(), messages::leftOutWithoutMap)};
  try {
    return {layer.surface(), std::nullopt, std::nullopt};
  } catch (const SurfaceError& error) {
    if (layer.hasAttribute()) throw;
    return {std::nullopt, std::nullopt,
            host::remarkOn(layer.label(), messages::layerLeftOut, host::complaint(error))};
  }
}

Reading readMap(const host::Layer& layer) {
  Reading reading = readSurface(layer);
  if (!reading.mesh) return reading;
  reading.map = layer.map(*reading.mesh);
  if (!reading.map) reading.note = host::remarkOn(layer.label(), messages::leftOutWithBadMap);
  return reading;
}

}  // namespace

std::optional<MeshSurface> surfaceWithPositions(const host::Task& task, const host::Layer& layer) {
  Reading reading = readSurface(layer);
  if (reading.note) task.tell(*reading.note);
  return std::move(reading.mesh);
}

std::vector<MappedLayer> mappedLayersIfAny(const host::Task& task, ThreadPool* pool) {
  const std::vector<host::Layer> layers = task.layers.visible(host::LayerKind::Surface);
  const auto read = [&](int i) { return readMap(layers[static_cast<size_t>(i)]); };
  ThreadPool alone(1);
  std::vector<Reading> readings =
      (pool ? *pool : alone).makeEach(static_cast<int>(layers.size()), read);
  std::vector<MappedLayer> found;
  for (size_t i = 0; i < layers.size(); ++i) {
    Reading& reading = readings[i];
    if (reading.note) task.tell(*reading.note);
    if (reading.map)
      found.push_back({layers[i], std::move(*reading.mesh), std::move(*reading.map)});
  }
  std::vector<host::Layer> mapped;
  for (const MappedLayer& layer : found) mapped.push_back(layer.layer);
  logSeveralRoots(task, mapped);
  return found;
}

std::vector<MappedLayer> mappedLayers(const host::Task& task, ThreadPool* pool) {
  task.layers.visibleSurfaces();  // says so where there is none
  std::vector<MappedLayer> found = mappedLayersIfAny(task, pool);
  if (found.empty()) throw host::Refusal(messages::noMappedLayer);
  return found;
}

}  // namespace sphere_propagation
