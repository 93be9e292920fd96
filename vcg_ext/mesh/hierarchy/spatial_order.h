// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A numbering by which what is near in space is near in memory: on large meshes half of the time
/// is waiting for it.

#include <vector>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// The indices of the points along a Morton curve (G. M. Morton, A computer oriented geodetic data
/// base, 1966) through their bounding box, 2^21 cells a side; points in one cell by index. points:
/// #P by 3, finite.
std::vector<int> spatialOrder(const Points& points);

}  // namespace sphere_propagation
