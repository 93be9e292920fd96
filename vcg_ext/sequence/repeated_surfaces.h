// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Surfaces that are there more than once: a file copied under another name, a cycle that ends with
/// its first phase again.

#include <vector>

#include "vcg_ext/sequence/sequence.h"

namespace sphere_propagation {

/// For each surface the first one that is the same, -1 where there is none: as many vertices and
/// faces, and each vertex within 1e-4 of the radius of a vertex of the other one, so that neither
/// another order of the vertices nor the digits of a text file make it another. One that was moved
/// or reflected is another.
std::vector<int> repeatedSurfaces(const Sequence& sequence);

}  // namespace sphere_propagation
