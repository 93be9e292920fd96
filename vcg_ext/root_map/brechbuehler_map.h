// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The initial map of Brechbuehler: colatitude and longitude, each the solution of a Laplace system
/// on the mesh.
///
/// C. Brechbuehler, G. Gerig, O. Kuebler, Parametrization of closed surfaces for 3-D shape
/// description, Computer Vision and Image Understanding 61(2), 1995; on triangle meshes instead of
/// voxel faces. Nothing in it says that the triangles come out unflipped: what comes back are
/// positions, to be certified or untangled.
///
/// Only the connectivity enters the two systems; the shape chooses the poles.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/mesh/closed_surface.h"

namespace sphere_propagation {

/// The vertices that go to (0, 0, 1) and (0, 0, -1).
struct Poles {
  int north = -1;
  int south = -1;
};

/// The extremes of the surface along its first principal axis (PCA of the vertices): as far from
/// each other as the shape is long. North is the end with the longer tail (positive skewness along
/// the axis), which turns with the shape; where the shape is symmetric, the end towards which the
/// axis' largest component is positive. Of vertices equally far out (1e-9 of the length) the one
/// with the smallest index.
Poles extremePoles(const ClosedSurface& surface);

/// Colatitude of each vertex, #V, in radians: 0 at the north pole, pi at the south pole, and at
/// every other vertex v
///   |N(v)| theta_v - sum of theta_w over the neighbours w = 0,
/// the mean of its neighbours' (their "latitude from diffusion").
/// Throws ParameterError unless the poles are two different vertices of the surface.
Eigen::VectorXd colatitudes(const ClosedSurface& surface, const Poles& poles);

/// Where the longitude jumps by 2 pi.
struct DateLine {
  /// The vertices from the north to the south pole, both included.
  std::vector<int> path;
  /// Pairs (vertex of the path, its neighbour to the west): the edges across which the longitude
  /// jumps. Poles are in no pair. An edge between two vertices of the path may be there in both
  /// directions: its jumps cancel.
  std::vector<std::array<int, 2>> crossings;
};

/// The path of steepest ascent in colatitude from the north to the south pole (as in the original;
/// of equal neighbours the one with the smallest index). A harmonic function has no peak between
/// the poles; where rounding makes one nevertheless, deep in a limb, the path is the shortest one
/// by number of edges: where the line runs changes no longitude by anything but multiples of 2 pi.
/// Neighbour poles leave no room between them: path = (north, south), and the one pair is (vertex
/// to the east, vertex to the west) of their edge. colatitudes: #V, any values. Throws
/// ParameterError as `colatitudes` does.
DateLine dateLine(const ClosedSurface& surface, const Poles& poles,
                  const Eigen::VectorXd& colatitudes);

/// Longitude of each vertex, #V, in radians, increasing counter-clockwise seen from outside the
/// north pole, not wrapped; 0 at the poles. At every other vertex v, N'(v) its neighbours without
/// the poles,
///   |N'(v)| phi_v - sum of phi_w over N'(v) = 2 pi (pairs with v to the west - pairs with v on the
///   path),
/// and phi = 0 at the first vertex of the path after the north pole (for neighbour poles: at the
/// first vertex that is no pole), by the original's device of adding 2 phi = 0 to that vertex'
/// equation ("longitude from diffusion"). Where the poles are neighbours, the vertices on both
/// sides of their edge count as neighbours, since no cycle separates the poles else. Throws
/// ParameterError as `colatitudes` does.
Eigen::VectorXd longitudes(const ClosedSurface& surface, const Poles& poles,
                           const DateLine& dateLine);

/// (sin theta cos phi, sin theta sin phi, cos theta) of each vertex: #V by 3 unit vectors, not
/// necessarily a valid map (never one between neighbour poles: the edge between antipodal points
/// has no place on the sphere). Throws ParameterError as `colatitudes` does.
Points brechbuehlerPositions(const ClosedSurface& surface, const Poles& poles);
/// The same between the extreme poles.
Points brechbuehlerPositions(const ClosedSurface& surface);

}  // namespace sphere_propagation
