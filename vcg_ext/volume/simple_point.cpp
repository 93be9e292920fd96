// SPDX-License-Identifier: GPL-3.0-only
// G. Bertrand, G. Malandain, A new characterization of three-dimensional simple points, 1994.

#include "vcg_ext/volume/simple_point.h"

#include <array>
#include <cstddef>

namespace sphere_propagation {
namespace {

constexpr Neighbourhood centre = 1U << 13, all = (1U << 27) - 1;

/// Masks of the neighbours that each of the 27 voxels has among them, the centre left out.
struct Adjacency {
  std::array<Neighbourhood, 27> byFaces{}, byFacesAndEdges{};
  constexpr Adjacency() {
    for (int a = 0; a < 27; ++a)
      for (int b = 0; b < 27; ++b) {
        const int x = a % 3 - b % 3, y = a / 3 % 3 - b / 3 % 3, z = a / 9 - b / 9;
        const int d = x * x + y * y + z * z;
        if (d == 1 && b != 13) byFaces[static_cast<size_t>(a)] |= 1U << b;
        if (d > 0 && d <= 2 && b != 13) byFacesAndEdges[static_cast<size_t>(a)] |= 1U << b;
      }
  }
};
constexpr Adjacency adjacency;

constexpr Neighbourhood withSquaredDistance(int distance) {
  Neighbourhood bits = 0;
  for (int n = 0; n < 27; ++n) {
    const int x = n % 3 - 1, y = n / 3 % 3 - 1, z = n / 9 - 1;
    if (x * x + y * y + z * z == distance) bits |= 1U << n;
  }
  return bits;
}
constexpr Neighbourhood faces = withSquaredDistance(1), edgeNeighbours = withSquaredDistance(2),
                        corners = withSquaredDistance(3);

size_t lowestBit(Neighbourhood bits) { return static_cast<size_t>(__builtin_ctz(bits)); }

/// Whether exactly one component of `set` has a voxel of `touching`.
bool oneComponent(Neighbourhood set, Neighbourhood touching,
                  const std::array<Neighbourhood, 27>& neighbours) {
  touching &= set;
  if (touching == 0) return false;
  Neighbourhood component = touching & (~touching + 1), frontier = component;
  while (frontier != 0) {
    const Neighbourhood found = neighbours[lowestBit(frontier)] & set & ~component;
    frontier &= frontier - 1;
    component |= found;
    frontier |= found;
  }
  return (touching & ~component) == 0;
}

/// Those of `candidates` that have a neighbour in `set`.
Neighbourhood reached(Neighbourhood set, Neighbourhood candidates) {
  Neighbourhood found = 0;
  for (; set != 0; set &= set - 1) found |= adjacency.byFaces[lowestBit(set)] & candidates;
  return found;
}

}  // namespace

bool isSimple(Neighbourhood neighbourhood) {
  const Neighbourhood byFace = neighbourhood & faces;
  const Neighbourhood byEdge = reached(byFace, neighbourhood & edgeNeighbours);
  const Neighbourhood byCorner = reached(byEdge, neighbourhood & corners);
  return oneComponent(byFace | byEdge | byCorner, faces, adjacency.byFaces) &&
         oneComponent(~neighbourhood & all & ~centre, faces | edgeNeighbours,
                      adjacency.byFacesAndEdges);
}

}  // namespace sphere_propagation
