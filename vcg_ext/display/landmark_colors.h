// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Colours that tell landmarks apart, and the same on all shapes: correspondence made visible.
/// Figure 2 of M. Kirschner and S. Wesarg, Propagation of shape parameterisation for the
/// construction of a statistical shape model of the left ventricle.

#include "vcg_ext/display/colors.h"

namespace sphere_propagation {

/// The index of a landmark as its hue: landmark j of `count` has the HSV colour (j / count of the
/// full turn, 1, 1). As the icosphere numbers its vertices in rows from pole to pole, the hue runs
/// once through the rainbow from the north pole of the map (red) over its equator (cyan) to the
/// south pole (red again), and a little along each row.
Colors landmarkColors(Eigen::Index count);

}  // namespace sphere_propagation
