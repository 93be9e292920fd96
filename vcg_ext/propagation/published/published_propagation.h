// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Propagation of a spherical parameterisation from one surface to another, as published:
/// M. Kirschner and S. Wesarg, "Propagation of shape parameterisation for the construction of a
/// statistical shape model of the left ventricle".
///
/// Where each step of the paper lives:
///   2   propagation tree                    propagation_tree.h
///   4a  anisotropic scaling                 scaledToExtents      principal_axes.h
///   4b  iterative closest points            alignRigidly         rigid_alignment.h
///   4c  the relation R                      mutualNearest        mutual_nearest.h
///   4d  fixed nodes                         fixNodes             here
///       triangles that point inwards        releaseInwardTriangles   here
///   4e  moving nodes, A x = b               placeMovingNodes     here
///   4f  smoothing                           smoothOnSphere       here
/// The paper gives no guarantee that the result is valid; what is still flipped after 4f is
/// repaired by untangling.h.

#include <vector>

#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/propagation/published/mutual_nearest.h"
#include "vcg_ext/propagation/transfer/map_transfer.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

/// The nodes (vertices) of a surface whose positions on the sphere are known; the others are moving
/// nodes.
struct FixedNodes {
  std::vector<char> isFixed;  ///< #V, 1 for fixed nodes
  Points positions;           ///< #V by 3, unit vectors; zero for moving nodes
  int count() const;
};

/// Step 4d, first half: fixed nodes get P_i(v) = P_ref(w) for (v, w) in R.
/// vertexCount: #V of the target; pairs: R, indices in range; referencePositions: #V of the
/// reference by 3, unit vectors.
FixedNodes fixNodes(int vertexCount, const std::vector<VertexPair>& pairs,
                    const Points& referencePositions);

/// Step 4d, second half: all nodes of triangles with three fixed nodes whose spherical normal
/// points inwards become moving. One pass, every triangle judged with the nodes as they come in.
/// faces: of the target. Returns the nodes that stay fixed; there may be none.
FixedNodes releaseInwardTriangles(const Triangles& faces, const FixedNodes& nodes);

/// Step 4e: A x = b for each coordinate of the moving nodes, with A_vv = |N(v)|, A_vw = -1 for
/// moving neighbours w, and b_v the sum of the positions of the fixed neighbours; then back to the
/// sphere. A moving node that the equations put at the centre of the sphere (within 1e-12) gets the
/// position of the first fixed node: it has no direction of its own, and the smoothing that follows
/// gives it one. target: the surface; nodes: its fixed nodes, at least one. Returns #V by 3 unit
/// vectors, those of fixed nodes unchanged. Throws PropagationError when no node is fixed.
Points placeMovingNodes(const ClosedSurface& target, const FixedNodes& nodes);

/// Step 4f: sweeps in which each node, fixed or moving, goes to the convex combination of its
/// neighbours weighted by 1 / |v - w|, the edge's length on the surface, and back to the sphere.
/// All neighbours are taken from the sweep before, so the order of the vertices does not matter.
/// Lengths below 1e-12 of the mean edge count as that; a node whose neighbours cancel stays where
/// it was. surface: its own shape, not the scaled one; positions: #V by 3 unit vectors; sweeps: >=
/// 0, the paper's 50. Returns #V by 3 unit vectors, not necessarily a valid map. Throws
/// ParameterError when sweeps is negative.
Points smoothOnSphere(const ClosedSurface& surface, const Points& positions, int sweeps);

/// The defaults are the paper's.
struct PublishedParameters {
  bool anisotropicScaling =
      true;                ///< step 4a; without it the centroids are brought together all the same
  int icpIterations = 30;  ///< step 4b, at most; >= 0
  int smoothingSweeps = 50;  ///< step 4f; >= 0
};

/// A node whose position is known beside those of the relation R.
struct NodeAt {
  int vertex;
  Vector3 position;  ///< unit length
};

/// Steps 4a to 4d: what a target and its reference have in common.
struct Correspondence {
  Points aligned;    ///< the target's vertices after steps 4a and 4b: #V by 3
  int pairs = 0;     ///< in the relation R of step 4c
  FixedNodes nodes;  ///< after step 4d; there may be none
};
/// anchors: in place of what R says of their vertices.
Correspondence findCorrespondence(const MappedSurface& reference, const ClosedSurface& target,
                                  const PublishedParameters& parameters = {},
                                  const std::vector<NodeAt>& anchors = {});

/// One arc of the propagation tree, steps 4a to 4f and the repair.
/// reference: the surface that has a map; target: the surface that gets one. The residual is the
/// distance of the target's vertices, after steps 4a and 4b, from the reference surface;
/// repairedFaces were flipped after step 4f. Throws ParameterError when a parameter is out of
/// range, PropagationError, which names both surfaces, when no node is fixed after step 4d, and
/// MapError when the result cannot be repaired.
TransferredMap propagateAsPublished(const MappedSurface& reference, const ClosedSurface& target,
                                    const PublishedParameters& parameters = {},
                                    const std::vector<NodeAt>& anchors = {});

}  // namespace sphere_propagation
