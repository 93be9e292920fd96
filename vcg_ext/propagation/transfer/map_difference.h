// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// How much two maps of one surface differ.

#include "vcg_ext/propagation/transfer/residual.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

struct MapDifference {
  Residual distance;  ///< between the vertex and the point that the other map sends to the same
                      ///< place, on average
  Residual angle;     ///< between the two positions of a vertex on the sphere, degrees
};

/// distance is what landmarks would differ by: how far from each vertex, straight through space,
/// the point lies to which `b` gives the position that the vertex has in `a`. Zero for equal maps;
/// turning both maps alike changes nothing. a, b: maps of one surface, that of `a`. Throws
/// ParameterError when they are maps of surfaces with different faces.
MapDifference differenceOf(const MappedSurface& a, const MappedSurface& b);

}  // namespace sphere_propagation
