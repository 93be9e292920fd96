// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The area-preserving map from coarse to fine: valid by construction, at a cost in proportion to
/// the number of vertices.
///
/// The surface is simplified to a tetrahedron, which is laid onto the sphere; then its vertices
/// come back, each into the kernel of its ring, and the map is improved on the way, where few
/// vertices have far to go (E. Praun and H. Hoppe, Spherical parametrization and remeshing, 2003;
/// X. Hu, X. Fu and L. Liu, Advanced hierarchical spherical parameterizations, 2018).

#include "vcg_ext/area/area_energy.h"
#include "vcg_ext/base/progress.h"
#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/mesh/closed_surface.h"

namespace sphere_propagation {

struct HierarchicalResult {
  Points positions;  ///< #V by 3 unit vectors
  int levels = 0;    ///< on which all vertices that were there were moved at once
  int steps = 0;     ///< global steps on the last of them
};

/// The map that minimises the area energy with these weights. It does not depend on the number of
/// threads, nor on the order of vertices and faces but for rounding and vertices at the same place;
/// it turns with the surface. Throws MapError when a vertex finds no place:
/// its ring's kernel is empty up to rounding.
HierarchicalResult hierarchicalMap(const ClosedSurface& surface, const AreaEnergyWeights& weights,
                                   ThreadPool& pool, const Progress& progress = {});

}  // namespace sphere_propagation
