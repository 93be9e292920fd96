// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// How round a surface is.

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// The largest distance of a point from the sphere that fits all best (least squares of |p - c|^2 -
/// r^2), as a share of its radius: 0 for points of a sphere. Infinite where no sphere fits, as for
/// points in a plane.
///
/// points: #P by 3, #P >= 4.
double deviationFromSphere(const Points& points);

}  // namespace sphere_propagation
