// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// On which side of an arc of the sphere a point lies, exactly.

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// The sign of det(p, q, x): 1 where x lies on the left of the great circle from p to q, -1 where
/// it lies on the right, 0 on it. By a floating-point filter in the manner of J. R. Shewchuk,
/// Adaptive precision floating-point arithmetic and fast robust geometric predicates, 1997, and
/// wide integers (Boost.Multiprecision) where it cannot tell. Coordinates: of size below 2.
int sideOfArc(const Vector3& p, const Vector3& q, const Vector3& x);

}  // namespace sphere_propagation
