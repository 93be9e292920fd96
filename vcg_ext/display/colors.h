// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Lists of colours, and what colours say of landmarks and displacements.

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// #N by 3 list of red, green, blue.
using Colors = Eigen::Matrix<unsigned char, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// The index of a landmark as its hue, the same on all shapes: the paper's picture of
/// correspondence (figure 2 of M. Kirschner and S. Wesarg, Propagation of shape parameterisation
/// for the construction of a statistical shape model of the left ventricle).
///
/// Landmark j of `count` has the HSV colour (j / count of the
/// full turn, 1, 1). As the icosphere numbers its vertices in rows from pole to pole, the hue runs
/// once through the rainbow from the north pole of the map (red) over its equator (cyan) to the
/// south pole (red again), and a little along each row: apex and base look alike, and drift round
/// the axis does not show. SpherePattern::Direction shows both.
Colors landmarkColors(Eigen::Index count);

/// How far each vertex has moved along the normal of where it was: positive outwards. #V.
/// from, to: #V by 3; faces: #F by 3, outward.
Eigen::VectorXd normalDisplacements(const Points& from, const Points& to, const Triangles& faces);

/// The diverging scale RdBu of M. Harrower and C. A. Brewer, ColorBrewer.org, 2003, which the
/// colour-blind can read too: -range and below blue, 0 nearly white, range and above red, linear
/// between its nine colours. values: #V, not finite counts as 0; range: above 0, else everything is
/// white.
Colors displacementColors(const Eigen::VectorXd& values, double range);

}  // namespace sphere_propagation
