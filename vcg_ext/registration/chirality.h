// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Whether one shape fits another as it is, or as its mirror image.

#include <vector>

#include "vcg_ext/registration/prepared_surface.h"
#include "vcg_ext/registration/rigid_alignment.h"

namespace sphere_propagation {

/// x -> rotation x + translation, where the matrix may mirror (determinant -1), which makes an
/// image of the shape. Products and inverses are those of RigidMotion.
using Isometry = RigidMotion;

/// Across the plane with this unit normal through a point.
Isometry reflection(const Vector3& normal, const Vector3& point);

/// (x, y, z) -> (2 plane - x, y, z), and the same along another axis.
Isometry reflection(int axis, double plane);

/// The isometry, proper or mirroring, that lays `from` on `to`, whatever poses the two are in: of
/// the poses of motionFromAnywhere, without its refinement; quicker by an order of magnitude.
Isometry roughIsometry(const PreparedSurface& from, const PreparedSurface& to, bool mirroring);

struct Fit {
  double distance = 0;  ///< in the radius of `to`
  Isometry motion;      ///< before the affine map
};

/// How far `from` lies off `to` at best, from the best two of these starts: root mean square
/// distance of the samples of each from the other's surface, after closest points, rigidly, and a
/// damped affine map, point to plane. Shapes that beat differ by an affine map to begin with; what
/// is left of their difference is small beside what mirroring changes. starts: at least one.
Fit bestFit(const PreparedSurface& from, const PreparedSurface& to,
            const std::vector<Isometry>& starts);

}  // namespace sphere_propagation
