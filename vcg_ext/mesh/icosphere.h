// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The icosphere: the mesh by which every surface is resampled, so that vertex j is the same
/// landmark on all. Step 5 of M. Kirschner and S. Wesarg, Propagation of shape parameterisation for
/// the construction of a statistical shape model of the left ventricle.

#include <optional>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

struct Icosphere {
  Points vertices;  ///< 10 f^2 + 2 by 3 unit vectors
  Triangles faces;  ///< 20 f^2 by 3, outward
};

/// The largest frequency: 10 million vertices.
constexpr int maxIcosphereFrequency = 1000;

/// Throws ParameterError unless the frequency is 1 to maxIcosphereFrequency; beyond, the text names
/// the memory that it would take.
void requireIcosphereFrequency(int frequency);

/// The unit icosahedron with every edge split into `frequency` equal parts, its faces into
/// frequency^2 triangles, and the new vertices moved to the sphere along their radius.
///
/// The icosahedron stands on a corner. The vertices are numbered in rows from the north pole (0, 0,
/// 1) to the south pole, and eastwards (by increasing longitude) in each row; row r begins at
/// longitude 0 as far as the upper corners (r <= f), shifts by half a step a row down to the lower
/// corners (r <= 2 f), and stays at 36 degrees from there. So neighbours have numbers that differ
/// by at most two rows (about 10 f), and a colour by number runs smoothly from pole to pole. Vertex
/// 0 is the north pole, the last one the south pole. The faces follow in the same rows.
///
/// Nested: place s of row r of icosphere(f) is place k s of row k r of icosphere(k f).
/// The same bit for bit on every machine (square roots and sums only).
///
/// frequency: 1 to maxIcosphereFrequency; 10 gives the paper's 1002 vertices. Throws as
/// requireIcosphereFrequency.
Icosphere icosphere(int frequency);

/// The frequency whose icosphere has this number of vertices and exactly this face list, if there
/// is one: that is how a mesh of landmarks is recognised. Costs nothing unless the numbers of
/// vertices and faces agree with an icosphere's.
std::optional<int> icosphereFrequency(Eigen::Index vertexCount, const Triangles& faces);

}  // namespace sphere_propagation
