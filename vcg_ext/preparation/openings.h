// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The openings of a mesh, and how they are closed.

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

/// Closes the openings of a mesh whose faces are oriented alike and whose vertices have one fan
/// each, in the order of their first edge: opening i gets lid number i + 1. A rim that touches
/// itself where one vertex was split is closed as several. What is left open is where no rim could
/// be followed round, and a single face.
std::vector<Opening> closeOpenings(BrokenMesh& mesh, LidShape shape, const Progress& progress = {});

}  // namespace sphere_propagation
