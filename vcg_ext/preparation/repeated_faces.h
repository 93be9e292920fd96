// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Faces that say nothing: there twice, or without an area.

#include "vcg_ext/preparation/broken_mesh.h"

namespace sphere_propagation {

/// Drops the faces that use one vertex twice; their other two edges lie on each other, so nothing
/// opens. Returns how many there were.
int dropFoldedFaces(BrokenMesh& mesh);

/// Drops the vertices that are not finite with their faces. Returns how many vertices there were.
int dropNonFiniteVertices(BrokenMesh& mesh);

/// Drops the faces that have the corners of an earlier one, whichever way round. Returns how many.
int dropRepeatedFaces(BrokenMesh& mesh);

/// Whether a face has no area: not higher than 1e-9 of its longest edge.
bool isFlat(const Points& vertices, const Triangles& faces, int f);

/// Gets rid of faces without area such that no crack opens: where two corners lie in one place the
/// edge between them is collapsed, where one corner lies on the opposite edge that edge is flipped;
/// on an open edge the face is left out. What neither the one nor the other mends, as it would fold
/// the mesh, stays, and so do those at edges of more than two faces. Returns how many are gone.
int mendFlatFaces(BrokenMesh& mesh);

}  // namespace sphere_propagation
