// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The order in which a mesh loses its vertices, so that each stage still has the shape of the
/// whole.

#include <vector>

#include "vcg_ext/base/progress.h"
#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/mesh/hierarchy/collapsible_mesh.h"

namespace sphere_propagation {

/// Collapses the mesh to a tetrahedron in rounds. In each round no two of the vertices that go are
/// neighbours, so that they may come back in any order, or at once. Returns how many vertices each
/// round took, the first round first.
///
/// The cost of moving u to v: the quadric of u at v (M. Garland and P. Heckbert, Surface
/// simplification using quadric error metrics, 1997; planes weighted by area) plus 1e-3 |u - v|^2
/// times the area that the faces around u stand for, more where v would get more than eight
/// neighbours. A round takes what costs no more than the median, or than the lower quartile when
/// fewer than 200 are left. A vertex with more than 24 neighbours waits until it has fewer: work
/// stays proportional to the number of vertices whatever the largest number of neighbours.
std::vector<int> simplify(CollapsibleMesh& mesh, ThreadPool& pool, const Progress& progress = {});

}  // namespace sphere_propagation
