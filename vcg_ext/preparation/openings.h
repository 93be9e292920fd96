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
  double outline = 0;                ///< length of a string around the rim, in its plane
  double relief = 0;                 ///< greatest distance from that plane, in the outline's radius
  int newVertices = 0;               ///< of its lid; a crack gets none
  int newFaces = 0;                  ///< 0: its two edges were laid on each other
  LidShape shape = LidShape::Flat;   ///< of its lid
};

/// Whether the rim goes to and fro, as where faces were deleted one by one: it is much longer than
/// its outline, and no staircase of faces along a plane. A lid follows it into its notches.
bool isRagged(const Opening& opening);

/// What joinShells did.
struct JoinedShells {
  std::vector<Opening> rings;    ///< one for each rim of the outer side that was joined
  int shells = 0;                ///< inner sides that were
  std::vector<Vector3> covered;  ///< centres of other rims of inner sides, over which a ring lies
};

/// Joins the sides of a wall that were saved without the rims between them, as a ventricle's inner
/// and outer surface, or the outer surface of both ventricles and their cavities. The outer side is
/// an open part; inner ones are open parts inside it (each has a tenth of the largest one's area at
/// least), a rim of which looks the same way as a rim of the outer side and lies beside it or
/// within it. Each is joined once, at its longest such rim, by a ring, so that the wall becomes a
/// sphere: a second ring would make a handle, so what else is open on either side is left to
/// closeOpenings. The ring is what connects the rims' points by the shortest lines (squared,
/// dynamic programming), between more than two rims the triangulation of smallest area, refined and
/// smoothed as a flat lid; ring i gets lid number i + 1. Inner faces then look inwards. No rings
/// where the mesh holds no such wall.
JoinedShells joinShells(BrokenMesh& mesh);

/// Whether it would join some.
bool hasShells(const BrokenMesh& mesh);

/// Closes the openings of a mesh whose faces are oriented alike and whose vertices have one fan
/// each, in the order of their first edge: opening i gets lid number i + 1. A rim that touches
/// itself where one vertex was split is closed as several. What is left open is where no rim could
/// be followed round, and a single face. joined: the rings come first; what one of them covers is
/// closed flat, so that it does not rise through it.
std::vector<Opening> closeOpenings(BrokenMesh& mesh, LidShape shape, const Progress& progress = {},
                                   const JoinedShells& joined = {});

}  // namespace sphere_propagation
