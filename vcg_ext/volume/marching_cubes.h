// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The surface at which a scalar image takes a value, as a triangle mesh that is closed whatever
/// the image.

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/volume/grid.h"

namespace sphere_propagation {

/// Closed, manifold and oriented outwards (from high values to low), of any number of parts and any
/// genus.
struct IsoSurface {
  Points vertices;  ///< #V by 3, mm
  Triangles faces;  ///< #F by 3
};

/// What runs over a face of a cell with two diagonally opposite corners inside.
enum class FaceRule {
  AsymptoticDecider,  ///< as the bilinear interpolant goes: the inside corners are joined when it
                      ///< is positive between
  SeparateInside,  ///< the inside corners are kept apart, whatever the values: the surface has the
                   ///< topology of the mask of the inside samples, connected through faces (the
                   ///< outside through faces and edges)
};

/// W. E. Lorensen and H. E. Cline, Marching cubes, Computer Graphics 21(4), 1987, without their
/// table: in each cell the surface's outline is traced over the six faces of the cell. Cells that
/// share a face decide in the same way what runs over it, so no crack can open; faces with two
/// diagonally opposite corners inside are decided as the bilinear interpolant goes (G. M. Nielson
/// and B. Hamann, The asymptotic decider, 1991), inside corners kept apart when that is a tie or
/// when `rule` asks for it. An outline is filled without using a diagonal that lies in a face of
/// the cell, which the neighbour might use too: each edge of the mesh has exactly two faces, and
/// the faces round each vertex form one fan.
///
/// One vertex for each grid edge with a sample above the iso value at one end and none at the
/// other, where linear interpolation puts it, but at least 0.001 of the edge away from both ends,
/// so that a sample that equals the iso value makes no face without area; in rare cells one more at
/// the middle. Outside the grid all is below the iso value: what touches the border is closed half
/// a spacing outside it. NaN counts as below.
///
/// Throws ParameterError when the grid's size, spacing or number of values is wrong or the iso
/// value is not finite.
IsoSurface marchingCubes(const ScalarGrid& grid, double isoValue,
                         FaceRule rule = FaceRule::AsymptoticDecider);

/// The connected part with the most vertices (of equal ones that of the smallest vertex index),
/// vertices and faces in their order; everything that was inside or beside it is dropped. Empty
/// stays empty.
IsoSurface largestPart(const IsoSurface& surface);

}  // namespace sphere_propagation
