// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Resampling of a mapped surface by the icosphere, and how much of the surface that loses.
/// Step 5 of M. Kirschner and S. Wesarg, Propagation of shape parameterisation for the construction
/// of a statistical shape model of the left ventricle.

#include <vector>

#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

struct Remeshed {
  Points landmarks;  ///< #D by 3, landmark j on the surface where its map lies under direction j
  std::vector<int> faces;  ///< #D: the face of the surface that landmark j lies on
};

/// Samples a surface through its map: landmark j is the point of the surface that the map sends to
/// direction j. With the same directions landmark j means the same place on all surfaces whose maps
/// correspond.
///
/// directions: #D by 3, any length but zero; icosphere(f).vertices, whose faces then connect the
/// landmarks. Quickest where each is near the one before. Throws ParameterError when a direction is
/// zero or not finite.
Remeshed remesh(const MappedSurface& surface, const Points& directions);

/// For each landmark the number of the lid that it lies on, 0 where it lies on none: that of the
/// first corner of its face that has one. Of the corners of a face on the rim of a lid the wall's
/// have none, and all faces at a new vertex of a lid are the lid's: so this is where lids are, but
/// for their faces that have all corners on the rim.
///
/// remeshed: of a surface with these faces (#F by 3); lids: #V numbers, 0 on the surface itself.
std::vector<int> lidsOfLandmarks(const Remeshed& remeshed, const Triangles& faces,
                                 const std::vector<int>& lids);

/// Distances between two meshes, in their unit.
struct SurfaceDistance {
  double mean = 0;
  double max = 0;
};

/// Where to look first for closest points. Hints save time and change nothing, but for landmarks
/// that are said to lie on the surface: their distance is 0, not what rounding makes of it.
struct DistanceHints {
  std::vector<int>
      landmarkFaces;  ///< all faces of the landmark mesh in an order in which neighbours are near
  std::vector<int>
      surfaceFaces;  ///< all faces of the surface in such an order; empty: the orders are found
  std::vector<int> nearCentroid;  ///< #G: a face of the surface near each face of the landmark
                                  ///< mesh; empty: none known
  std::vector<int> nearVertex;    ///< #V: a face of the landmark mesh near each vertex of the
                                  ///< surface; empty: none known
  bool landmarksOnSurface = false;
};

/// Distance between a landmark mesh and its source, both ways.
///
/// From the landmark mesh to the closest point of the surface: at its vertices and the centroids of
/// its faces, a face weighing its centroid with 3/4 and its corners with 1/12 of its area each
/// (exact for functions of degree 2). From the surface to the closest point of the landmark mesh:
/// at its vertices, each weighing a third of the area of its faces. mean = the average of the two
/// weighted means; max = the largest distance of any sample, either way.
///
/// landmarks: #L by 3; faces: #G by 3, at least one.
SurfaceDistance surfaceDistance(const Points& landmarks, const Triangles& faces,
                                const ClosedSurface& surface, const DistanceHints& hints = {});

}  // namespace sphere_propagation
