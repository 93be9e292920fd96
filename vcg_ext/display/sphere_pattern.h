// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Colours for the points of the unit sphere. Drawn on a surface through its map they show where
/// each place went: the same point of the sphere has the same colour on every surface.
///
/// Longitude and colatitude are those of sphere_coordinates.h. The hue turns once with the
/// longitude and fades towards the poles, light in the north and dark in the south, so that no two
/// places far apart look alike.

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/display/colors.h"

namespace sphere_propagation {

enum class SpherePattern {
  Checkerboard,  ///< light and dark fields between meridians and parallels
  Graticule,  ///< meridians and parallels as stripes on white; the 0 meridian and the equator are
              ///< black
  Direction,  ///< hue and lightness alone, without edges
};

/// Most fields from pole to pole.
constexpr int maxPatternCells = 1000;

struct SpherePatternParameters {
  SpherePattern pattern = SpherePattern::Checkerboard;
  int cells =
      8;  ///< fields from pole to pole, 2 to maxPatternCells; around() of them along the equator

  /// Fields along the equator: half as many again, and even, so that light and dark alternate all
  /// round. Fields are square at latitude 41 degrees.
  int around() const { return 2 * ((3 * cells + 3) / 4); }
};

/// Fields from pole to pole that a mesh of so many vertices can show: some six by six vertices
/// each, an even number from 4 to 16.
int cellsFor(Eigen::Index vertices);

/// Mean length of the edges at each vertex on the sphere, in radians, #V. positions: #V by 3 unit
/// vectors; faces: of a closed mesh.
Eigen::VectorXd sphereSpacing(const Points& positions, const Triangles& faces);

/// The pattern at points of the sphere.
///
/// positions: #N by 3 unit vectors. spacing: #N, the distance to neighbouring vertices in radians,
/// 0 for the pattern as it is. Edges of the pattern are blended over the spacing (a box filter in
/// longitude and in latitude): colours that are interpolated over triangles then change where the
/// edge is, and not where the next vertex happens to be; stripes are at least as wide; and what is
/// too fine for the mesh becomes its mean colour in place of noise. Throws ParameterError when the
/// number of cells is out of range.
Colors sphereColors(const Points& positions, const Eigen::VectorXd& spacing,
                    const SpherePatternParameters& parameters);

/// Colours of area ratios (map_measures.h): light grey at 1, red above, blue below; the same
/// distance from grey for r and 1/r; fully red at `limit` and blue at 1/limit and beyond. ratios:
/// #N; limit > 1 (ParameterError).
Colors areaRatioColors(const Eigen::VectorXd& ratios, double limit);

}  // namespace sphere_propagation
