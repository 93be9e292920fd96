// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Which voxels can change sides without a change of topology.

#include <cstdint>

namespace sphere_propagation {

/// The 3 x 3 x 3 voxels round a voxel: bit (x + 1) + 3 (y + 1) + 9 (z + 1) says whether the one at
/// (x, y, z) is inside; bit 13 is the voxel itself.
using Neighbourhood = std::uint32_t;

/// Whether the voxel at the centre is simple: taking it in or out joins and splits nothing, makes
/// and fills no cavity, and opens and closes no handle. Inside voxels are connected through faces
/// (6 neighbours), outside ones through faces and edges (18 neighbours): the pair that marching
/// cubes realises when it keeps inside corners apart (J.-O. Lachaud and A. Montanvert, Continuous
/// analogs of digital boundaries: a topological approach to iso-surfaces, 2000).
///
/// G. Bertrand and G. Malandain, A new characterization of three-dimensional simple points, Pattern
/// Recognition Letters 15, 1994: among the 26 neighbours there is one component of the inside,
/// connected through faces, that touches the centre by a face (what takes more than three steps
/// through faces from there, as round a corner, does not count), and one of the outside, connected
/// through faces and edges, that touches it by a face or an edge. Bit 13 does not matter.
bool isSimple(Neighbourhood neighbourhood);

}  // namespace sphere_propagation
