// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The conformal maps of the sphere onto itself, used to spread a map evenly: angles stay, areas
/// are balanced.

#include <Eigen/Core>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// Applies a Moebius transformation of the sphere after which the weighted mean of the positions is
/// its centre: unique up to a rotation as long as no point carries half of the weight or more.
///
/// Newton's iteration for the conformal barycentre (A. Baden, K. Crane, M. Kazhdan, Moebius
/// registration, Computer Graphics Forum 37(5), 2018), on a convex function of the hyperbolic ball,
/// so that a line search makes it safe.
///
/// positions: #P by 3 unit vectors; weights: #P, none negative, not all zero (a vertex' share of
/// the surface). Returns #P by 3 unit vectors with |weighted mean| < 1e-12, or as far as 200 steps
/// come where that is impossible.
Points balanceByMoebius(Points positions, const Eigen::VectorXd& weights);

}  // namespace sphere_propagation
