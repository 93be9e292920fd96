// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Displacements as colours.

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/display/colors.h"

namespace sphere_propagation {

/// How far each vertex has moved along the normal of where it was: positive outwards. #V.
/// from, to: #V by 3; faces: #F by 3, outward.
Eigen::VectorXd normalDisplacements(const Points& from, const Points& to, const Triangles& faces);

/// The diverging scale RdBu of M. Harrower and C. A. Brewer, ColorBrewer.org, 2003, which the
/// colour-blind can read too: -range and below blue, 0 nearly white, range and above red, linear
/// between its nine colours. values: #V, not finite counts as 0; range: above 0, else everything is
/// white.
Colors displacementColors(const Eigen::VectorXd& values, double range);

}  // namespace sphere_propagation
