// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A valid map near given positions, however far those are from one.

#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

/// The surface is simplified to a tetrahedron, whose vertices take their positions (or, where these
/// do not make a tetrahedron, those of a regular one turned towards them), and refined again: each
/// vertex comes back at its position where no face around it flips there, else inside the kernel of
/// its ring and from there towards its position as far as that goes. Every time the number of
/// vertices has doubled, all that are elsewhere try again, and lean on their neighbours meanwhile.
/// So what is right stays exactly as it is, and only what contradicts itself moves, whatever the
/// size of the folds. (The hierarchy is that of hierarchical_map.h.)
///
/// Where positions crowd so much that a vertex finds no place (its ring's kernel is empty up to
/// rounding), those around it are given up, and all is laid again; in the end all are.
///
/// positions: #V by 3, unit vectors; those that are not finite or zero ask for no place.
/// Throws MapError when a vertex finds no place even so.
MappedSurface nearbyMap(const ClosedSurface& surface, const Points& positions);

}  // namespace sphere_propagation
