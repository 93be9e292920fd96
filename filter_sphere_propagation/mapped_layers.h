// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The surfaces that have a map: what the filters behind the propagation work on.

#include <optional>
#include <vector>

#include "host/filter.h"
#include "vcg_ext/base/thread_pool.h"

namespace sphere_propagation {

/// The surface of a layer that stores positions on the sphere. Empty, with a line in the log, where
/// it stores nothing, or texture coordinates only and is not a closed surface: those are ordinary
/// ones. Throws SurfaceError where it has the attribute.
std::optional<MeshSurface> surfaceWithPositions(const host::Task& task, const host::Layer& layer);

struct MappedLayer {
  host::Layer layer;
  MeshSurface mesh;
  MappedSurface map;
};

/// All visible surfaces with a valid map, in layer order; those that carry something else are named
/// in the log, and so are maps that come from different roots. pool: who reads them; nullptr: the
/// calling thread alone.
std::vector<MappedLayer> mappedLayersIfAny(const host::Task& task, ThreadPool* pool = nullptr);

/// All visible surfaces with a valid map, in layer order; the others are named in the log.
/// Throws MapError, which says what to do, when there is none.
std::vector<MappedLayer> mappedLayers(const host::Task& task, ThreadPool* pool = nullptr);

}  // namespace sphere_propagation
