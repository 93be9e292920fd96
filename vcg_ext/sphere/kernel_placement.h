// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Where a vertex may come back: inside the kernel of its ring, so that no face around it is
/// flipped.

#include <vector>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// A point x on the sphere with det(x, rim[i], rim[i + 1]) > 0 for all i: the centroid of the
/// kernel of the spherical polygon `rim` (unit vectors, counter-clockwise), or of the part of it
/// near `near`, in the gnomonic projection from the centre to the plane that touches the sphere at
/// `near`, where great circles are straight. The half-planes of the sides are cut off one after the
/// other. `near`: a unit vector, best a corner of the kernel; the polygon may be larger than a
/// hemisphere. Takes the first of several windows and centres in which all faces around x get a
/// solid angle of at least `minAngle`; returns false when none does: the kernel is empty up to
/// rounding.
bool placeInKernel(const std::vector<Vector3>& rim, const Vector3& near, double minAngle,
                   Vector3& x);

/// The least solid angle of the faces between x and the sides of the rim; -1 where one is not
/// admissible (admissible.h).
double minSolidAngle(const std::vector<Vector3>& rim, const Vector3& x);

}  // namespace sphere_propagation
