// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What closes one opening of a surface.

#include <functional>
#include <vector>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

enum class LidShape {
  Curved,  ///< the surface goes on over the rim and bends as little as it can
  Flat,    ///< as flat as the rim lets it be: in a plane where the rim lies in one
};

/// An opening as its lid sees it.
struct Rim {
  Points points;            ///< #R by 3, counter-clockwise seen from outside the surface
  Points wall;              ///< #R by 3: normal of the face at the edge from point i to i + 1
  Eigen::VectorXd spacing;  ///< #R: length of the surface's edges near by, which the lid's are to
                            ///< have
  Points onward;            ///< #R by 3: unit vectors along which the surface would go on; for
                            ///< curved lids
  std::function<bool(int i, int j)> joined;  ///< whether an edge joins two points already
};

struct Lid {
  Points vertices;  ///< the new ones
  Triangles faces;  ///< its indices: first the rim's points, then the new vertices
};

/// P. Liepa, Filling holes in meshes, Symposium on Geometry Processing 2003: the rim is
/// triangulated (G. Barequet and M. Sharir, Filling gaps in the boundary of a polyhedron, CAGD
/// 12(2), 1995) with the smallest largest angle between neighbouring faces and among those the
/// smallest area, by dynamic programming; for flat lids by area alone. Rims of more than 200 points
/// first as a polygon of some 100 of them, then between these. Points that follow each other more
/// closely than the surface's edges, as where a plane cut its faces, wait until the lid is made of
/// the others: then the faces at the rim are split at them. Triangles are split until they are
/// as small as those around, and edges flipped to be Delaunay. Then the new vertices are placed: of
/// a flat lid such that it is a membrane in the rim (Dirichlet energy), of a curved one such that,
/// with a strip of the wall that stands for the surface around, it is a thin plate (squared
/// Laplacian; M. Botsch and L. Kobbelt, An intuitive framework for real-time freeform modeling,
/// 2004). Cotangent weights, made anew three times as the lid takes its shape. A plate that rises
/// over the membrane by more than 0.6 of the greatest distance from the rim, as over a ragged one,
/// is brought nearer to it.
///
/// No edge of the lid joins two points that are joined already; where that leaves no triangulation,
/// all points are joined to one at their middle.
Lid makeLid(const Rim& rim, LidShape shape);

/// The triangulation of smallest area of a polygon, by dynamic programming as for lids; of a
/// polygon of more than 400 points first between some 200 of them. Empty where there is none.
///
/// rim: its points, and which of them are joined already, are looked at; polygon: indices of them
/// in order round the polygon, where lines that join several rims to one are run along twice.
Triangles polygonFaces(const Rim& rim, const std::vector<int>& polygon);

/// A surface between rims from one that has their points alone: refined as a lid is, and placed as
/// a flat one.
///
/// rim: of all rims the points, one rim after another; walls and ways onward are not looked at;
/// faces: #F by 3, indices of its points.
Lid makeBand(const Rim& rim, const Triangles& faces);

}  // namespace sphere_propagation
