// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Poses that a registration may begin from, and what tells the good ones.

#include <vector>

#include "vcg_ext/registration/prepared_surface.h"
#include "vcg_ext/registration/rigid_alignment.h"

namespace sphere_propagation {

/// Centres together, turned as it is.
RigidMotion poseAsTurned(const PreparedSurface& from, const PreparedSurface& to);

/// The four that lay principal axes on principal axes. mirroring: the four that mirror besides
/// (the rotation's determinant is -1).
std::vector<RigidMotion> posesByAxes(const PreparedSurface& from, const PreparedSurface& to,
                                     bool mirroring = false);

/// As it is turned (mirroring: across each plane of coordinates), by axes, and the rotations of the
/// icosahedron relative to the axes: no rotation is farther than 45 degrees from all of them.
std::vector<RigidMotion> posesFromAnywhere(const PreparedSurface& from, const PreparedSurface& to,
                                           bool mirroring = false);

/// The 60 rotations of the icosahedron onto itself, the first of which is none: no rotation is
/// farther than 45 degrees from all of them.
std::vector<Eigen::Matrix3d> icosahedralRotations();

/// Sum of the squared distances of the moved points from the nearest vertices.
double misfit(const Points& points, const RigidMotion& motion, const VertexLocator& vertices);

}  // namespace sphere_propagation
