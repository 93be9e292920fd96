// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The openings of a mesh, and how they are closed.

#include <optional>
#include <vector>

#include "vcg_ext/base/progress.h"
#include "vcg_ext/preparation/broken_mesh.h"
#include "vcg_ext/preparation/lid.h"

namespace sphere_propagation {

struct Opening {
  int edges = 0;                     ///< of its rim
  double perimeter = 0;              ///< in the mesh's unit
  Vector3 centre = Vector3::Zero();  ///< mean of the rim
  int newVertices = 0;               ///< of its lid; a crack gets none
  int newFaces = 0;                  ///< 0: its two edges were laid on each other
};

/// Joins the two sides of a wall, as of a ventricle's inner and outer surface that were saved
/// without the rim between them, by a ring: where the two parts of largest area (the smaller has a
/// tenth of the other's at least) are open, each in one place above all, one lies inside the other,
/// and their rims look the same way and lie side by side. The ring is what connects their points by
/// the shortest lines (squared, dynamic programming), refined and smoothed as a flat lid; it gets
/// lid number 1. Inner faces then look inwards. Nothing where the mesh holds no such wall.
std::optional<Opening> joinShells(BrokenMesh& mesh);

/// Whether it would.
bool hasShells(const BrokenMesh& mesh);

/// Closes the openings of a mesh whose faces are oriented alike and whose vertices have one fan
/// each, in the order of their first edge: opening i gets lid number i + 1. A rim that touches
/// itself where one vertex was split is closed as several. What is left open is where no rim could
/// be followed round, and a single face. openings: those that are closed already.
std::vector<Opening> closeOpenings(BrokenMesh& mesh, LidShape shape, const Progress& progress = {},
                                   std::vector<Opening> openings = {});

}  // namespace sphere_propagation
