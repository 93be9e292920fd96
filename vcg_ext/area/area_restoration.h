// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Moving a map towards area preservation while it keeps its meaning: what lay under a direction
/// stays near it.

#include "vcg_ext/base/progress.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

/// Gives each face the solid angle s^(1 - amount) a^amount, all scaled to 4 pi together, where s is
/// what it has on the given map and a its share of the surface, by minimising the energy of
/// area_energy.h. Its shape term compares with the faces of the given map, not with those of the
/// surface: of all maps with these areas the one asked for deforms the given one the least, and
/// nothing happens where nothing has to. (Maps of given areas are many: with the surface's shapes
/// the vertices slide towards the map that the surface prefers, and surfaces that corresponded no
/// longer do.) A rotation is no deformation: in the end the sphere is turned back onto the given
/// map, in the least squares of the vertices weighted by their areas on the surface.
///
/// amount: in [0, 1]. 0 returns the map bit for bit; 1 preserves areas all but exactly.
/// Every step keeps the map valid. Throws ParameterError when amount is outside its range or the
/// map is not the surface's.
MappedSurface restoreArea(const MappedSurface& map, double amount, const Progress& progress = {});

/// The same where it is needed most: faces whose solid angle is less than 1 / bound or more than
/// bound times their share of the surface get just that, all others keep theirs (all scaled to 4 pi
/// together). Where there is no such face the map is returned bit for bit. bound: 1, which
/// preserves areas all but exactly, or more; else a ParameterError is thrown.
MappedSurface boundAreas(const MappedSurface& map, double bound);

/// The share of the surface that lies in faces with less than 1 / bound of their share of the
/// sphere. bound: above 0.
double squeezedShare(const MappedSurface& map, double bound);

/// The least bound, 1 or more, by which no larger share of the surface than this is squeezed.
double boundOfSqueezing(const MappedSurface& map, double share);

}  // namespace sphere_propagation
