// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Shapes between shapes. M. Alexa, Merging polyhedral shapes with scattered features, 2000: two
/// surfaces with maps that correspond get one connectivity, and each vertex moves from its place on
/// the one to its place on the other.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "vcg_ext/base/progress.h"
#include "vcg_ext/morphing/morph_path.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

enum class MorphConnectivity {
  Icosphere,  ///< one for all: vertex j is landmark j everywhere
  Union,      ///< of each two neighbours, whose shapes it keeps exactly (sphere_overlay.h)
};

struct MorphParameters {
  int steps = 3;  ///< shapes between two neighbours, at least 1
  MorphConnectivity connectivity = MorphConnectivity::Icosphere;
  int frequency = 10;  ///< of the icosphere
  MorphPath path = MorphPath::Linear;
  bool closed = false;  ///< from the last back to the first as well
  bool ends = true;     ///< the given shapes, too, in the same connectivity
  int threads = 0;      ///< 0: as many as the machine runs at once; the result is the same
};

/// Vertices of all shapes of a morph together, at most: about 6 GB of layers in MeshLab.
constexpr long maxMorphVertices = 20'000'000;

struct MorphShape {
  size_t from, to;  ///< the neighbours
  double share;     ///< 0 at the one, 1 at the other
  /// The shape with its map; nothing where it encloses less than a thousandth of what the smaller
  /// neighbour does, as halfway between two that lie in opposite poses.
  std::optional<MappedSurface> map;
  double volume = 0;  ///< that it encloses
};

struct Morph {
  std::vector<MorphShape> shapes;  ///< in order of time
  /// Of edges, by pair of neighbours; Union only. Nothing where the two maps have no union, and
  /// the pair therefore no shapes.
  std::vector<std::optional<int>> crossings;
};

/// surfaces: two or more. Between neighbours k and k + 1 the shape at share s is sum_i w_i x_i, w
/// the weights of the path at k + s, x_i the places on surface i of one point of the sphere. Of the
/// ends the first one's is made first, and after each pair the second one's.
///
/// Throws RangeError.
Morph makeMorph(const std::vector<MappedSurface>& surfaces, const MorphParameters& parameters = {},
                const Progress& progress = {});

/// "A to B 25 %".
std::string nameOfMorph(const std::string& from, const std::string& to, double share);

}  // namespace sphere_propagation
