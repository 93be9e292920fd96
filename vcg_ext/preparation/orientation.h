// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Parts of a mesh, and which way their faces look.

#include "vcg_ext/preparation/broken_mesh.h"

namespace sphere_propagation {

/// What was dropped with the smaller parts.
struct DroppedSurfaces {
  long parts = 0;
  double largestShare = 0;  ///< area of the largest of them / area of what was kept
};

/// Keeps the part (faces connected through edges) of largest area; of equal ones that of the first
/// face.
DroppedSurfaces keepLargestSurface(BrokenMesh& mesh);

/// Turns faces such that those at edges with two faces are oriented alike, as the larger part of
/// each part's area was. Where a part has one side only (a Moebius strip) some edges stay between
/// faces of opposite orientation.
void orientAlike(BrokenMesh& mesh);

/// Whether the part of largest area has one side only. The mesh is oriented alike, see above; where
/// edges have more than two faces this is not known, and false.
bool isOneSided(const BrokenMesh& mesh);

/// Turns parts that enclose a negative volume inside out.
void orientOutwards(BrokenMesh& mesh);

/// Turns a face.
void turnFace(BrokenMesh& mesh, int f);

}  // namespace sphere_propagation
