// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A mesh whose sheets meet anyhow becomes a manifold with boundary.

#include "vcg_ext/preparation/broken_mesh.h"

namespace sphere_propagation {

/// What was done to the sheets of a mesh.
struct SeparatedSheets {
  long edges = 0;           ///< that had more than two faces
  long vertices = 0;        ///< that had more than one fan of faces, and none of these edges
  long droppedFaces = 0;    ///< of fins and internal membranes
  double droppedShare = 0;  ///< their area / area of all faces
  long splitVertices = 0;   ///< vertices that were added, where sheets were cut apart
};

/// Afterwards each edge has one or two faces and the faces round each vertex form one fan, whatever
/// the mesh: there is no input for which this goes round in a circle.
///
/// 1. Fins and membranes. Where sheets (faces connected through edges with two faces) meet in an
/// odd way, the least of them is dropped, one after another: by area; ten times dearer where it
/// goes on smoothly into another sheet at most of its edges, for then the third one is the fin;
/// four times cheaper where it ends in an open edge. A sheet whose loss would open an edge, and one
/// that has half of the area, stays. 2. Cutting (A. Gueziec, G. Taubin, F. Lazarus and B. Horn,
/// Cutting and stitching: converting sets of polygons to manifold surfaces, IEEE TVCG 7(2), 2001).
/// At edges that still have more than two faces these are paired: those of one sheet, then those
/// with the smallest inside between them. What is not paired becomes an open edge. Each vertex is
/// copied for each of its fans; an edge that would still lie between the same two vertices gets one
/// at its middle.
SeparatedSheets separateSheets(BrokenMesh& mesh);

}  // namespace sphere_propagation
