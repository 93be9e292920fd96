// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// How far the voxels of a binary image are from its border.

#include "vcg_ext/volume/grid.h"

namespace sphere_propagation {

/// The exact Euclidean distance to the nearest voxel centre of the other kind, less half the
/// smaller spacing (so that it is 0 about half way between the two kinds), positive inside, in the
/// unit of `spacing`. P. F. Felzenszwalb and D. P. Huttenlocher, Distance transforms of sampled
/// functions, Theory of Computing 8, 2012: lower envelopes of parabolas, axis by axis, in linear
/// time.
///
/// spacing: between voxels along x, y, z, positive. dimensions: 3; or 2, for each slice z by
/// itself. Where there is no voxel of the other kind (in the slice), the value is + or - infinity.
std::vector<float> signedDistance(const Mask& mask, const Vector3& spacing, int dimensions = 3);

}  // namespace sphere_propagation
