// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A map with few of its vertices, on which moving costs little, and the way back to all of them:
/// H. Hoppe, Progressive meshes, 1996, on the sphere.

#include <functional>
#include <vector>

#include "vcg_ext/mesh/hierarchy/collapsible_mesh.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

class CoarseMap {
 public:
  /// Takes vertices away until so many are left, or none may go: those that are kept stay (#V, 1
  /// for each), and on the sphere no face becomes a sliver, or long, that was none. Rounds take
  /// evenly from everywhere: what counts is the density on the sphere.
  CoarseMap(const MappedSurface& map, const std::vector<char>& kept, int vertices);

  /// What is left. Throws SurfaceError or MapError where that is no map.
  MappedSurface map() const;

  /// The same point of the surface, of a face whose corners are all kept.
  SurfacePoint onCoarse(const SurfacePoint& point) const;

  /// What is there on the way back.
  struct Stage {
    FaceRings rings;
    /// Each #V by 3: on the surface (scaled), on the sphere in the given map, and as they lie now.
    Points vertices, before, positions;
    std::vector<char> kept;
  };

  /// Brings the vertices back into another map of what is left (positions in the order of map()),
  /// each where those around it carry it: at its mean value coordinates among them in the given map
  /// (M. Floater, Mean value coordinates, 2003), or else inside the kernel of its ring. Every time
  /// that there are `ratio` times as many, `improve` may move them, its faces staying valid. Once
  /// only. Throws MapError where a vertex finds no place.
  MappedSurface refined(const Points& positions, double ratio,
                        const std::function<void(Stage&)>& improve);

 private:
  void coarsen(int vertices);
  int bestCollapse(int v);
  void bringBack(int v);
  void improveStage(const std::function<void(Stage&)>& improve);

  MappedSurface given_;
  std::vector<int> order_;  // from the mesh's vertices, by which all below go, to the surface's
  CollapsibleMesh mesh_;
  std::vector<char> kept_;
  Points before_, positions_;  // in the given map, and in the other
  std::vector<int> rounds_;    // how many vertices each took
  FaceRings rings_;            // of what is left
  std::vector<int> left_;      // its vertices, ascending
  std::vector<Vector3> rimBefore_, rim_;
};

}  // namespace sphere_propagation
