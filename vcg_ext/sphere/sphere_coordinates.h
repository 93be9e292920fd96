// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The paper's form of a map, P(v) = (theta, phi), scaled to [0, 1] so that it fits a texture
/// coordinate.
///   u = longitude / 2 pi, in [0, 1);   v = colatitude / pi, in [0, 1];
///   unit vector = (sin colatitude cos longitude, sin colatitude sin longitude, cos colatitude).

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// (u, v) of a unit vector; at the poles u = 0.
Vector2 textureCoordinate(const Vector3& position);

/// The unit vector at (u, v).
Vector3 spherePosition(const Vector2& textureCoordinate);

}  // namespace sphere_propagation
