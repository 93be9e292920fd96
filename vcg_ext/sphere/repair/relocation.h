// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Repair of a few faces that folded, by moving single vertices as little as it takes.

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// Moves the vertices of flipped faces, one after another, to where the least of their faces is
/// largest, of some places between here and the middle of the neighbours and round these; where
/// that does not do for long, those of their neighbours as well. Where faces are too large to
/// follow a smooth flow a few fold, and to lay their whole neighbourhood anew, as untangle does
/// (untangling.h), can take a limb off its place; this keeps all else where it is.
///
/// positions: #V by 3 unit vectors; they are changed. Returns the number of faces that were
/// flipped; -1 where some still are.
int relocateFlipped(const Triangles& faces, Points& positions);

}  // namespace sphere_propagation
