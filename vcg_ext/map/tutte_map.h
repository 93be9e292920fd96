#pragma once
/// The initial map of last resort: it looks at nothing but the connectivity, and folds nowhere, whatever the shape.
///
/// W. T. Tutte, How to draw a graph, 1963; M. S. Floater, One-to-one piecewise linear mappings over triangulations,
/// 2003.

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/mesh/closed_surface.h"

namespace sphere_propagation {

/// A position for each vertex, #V by 3 unit vectors: the vertex with most neighbours (of those with equally many the
/// one with the smallest index) is the south pole, its neighbours are a regular polygon on a circle a little north of
/// the equator, and all others lie at the mean of their neighbours in the gnomonic projection from the centre to the
/// plane that touches the north pole. That projection keeps straight lines, so the drawing in the plane, which has no
/// flipped triangle (Floater), has none on the sphere. Always a valid map but for rounding: areas fall exponentially
/// with the distance from the polygon by edges, so on large surfaces faces vanish. Angles and areas are poor.
Points tuttePositions(const ClosedSurface& surface);

}  // namespace sphere_propagation
