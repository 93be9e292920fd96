// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Shapes that are hard to spread over a sphere, of any size: limbs, branches, sheets, coils; and a
/// noisy blob.

#include "tests/core/test_meshes.h"

namespace sphere_propagation::test {

/// Loop's subdivision, so many times (each makes four faces of one): C. Loop, Smooth subdivision
/// surfaces based on triangles, 1987.
Mesh subdivided(Mesh mesh, int times);

/// A sphere of 10 f^2 + 2 vertices with bumps as large as a third of its radius, and radial noise
/// of `noise` mean edge lengths (standard deviation).
Mesh blob(int frequency, double noise, unsigned seed);
/// tetrapod(segments), subdivided: four smooth limbs.
Mesh limbs(int segments, int subdivisions);
/// A trunk that branches in three `depth` times; each branch is a tube of so many segments.
/// Subdivided.
Mesh tree(int depth, int segments, int subdivisions);
/// A round flat sheet with a rounded rim: radius 1, thickness 0.02, about 3 rings^2 vertices on
/// each side.
Mesh disc(int rings);
/// A tube of radius 0.2 along a helix of so many turns: `around` vertices in each of `along` rings,
/// closed at the ends.
Mesh coil(double turns, int around, int along);

}  // namespace sphere_propagation::test
