// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Faces that lie side by side get the vertices that they share.

#include "vcg_ext/preparation/broken_mesh.h"

namespace sphere_propagation {

/// Welds vertices on open edges: first those in exactly one place, then those nearer to each other
/// than `tolerance` of the box's diagonal, or a few units in the last place of single precision,
/// but never than a tenth of their shortest edge. Of three rims in nearly one place two may meet
/// exactly: the third one is welded to them all the same, where it belongs to another sheet (faces
/// connected through edges with two faces). What is closed already is not touched, so that thin
/// walls stay apart. Returns how many vertices were merged into others.
int weldOpenEdges(BrokenMesh& mesh, double tolerance = 1e-6);

}  // namespace sphere_propagation
