// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Surfaces that lie somewhere else than the rest of the sequence: shifted, or turned round.
/// (Mirrored ones: mirroring.h.)
///
/// A motion model cannot tell a surface that was moved as a whole from tissue that slid along its
/// surface: it has to know the pose first. Phases of one scan share a frame, and what they move in
/// it is the heart's; so a surface is taken as it lies unless another pose fits its parent far
/// better.

#include <vector>

#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/registration/rigid_alignment.h"
#include "vcg_ext/sequence/propagation_tree.h"
#include "vcg_ext/sequence/sequence.h"

namespace sphere_propagation {

struct SurfacePose {
  RigidMotion toRoot;  ///< lays the surface where it would lie in the root's frame; the identity
                       ///< where it lies there
  bool moved = false;  ///< whether it is in another pose than its parent
  double shift = 0;    ///< of its centre by toRoot, in the unit of the vertices
  double angle = 0;    ///< of toRoot's rotation, degrees
  bool byAnchors = false;  ///< whether anchors say so; then it is not `moved`
};

/// tree: one entry per surface of the sequence; a surface's pose is found relative to its
/// parent's. Distances of shapes are those of shape_alignment.h: a surface within 0.05 R of its
/// parent (R: the radius of the sphere of its area) is as it should be; of others the best of many
/// poses counts where it makes the distance at least 1.6 times smaller (over a heart's cycle,
/// neighbours or not, it makes it at most 1.4 times smaller). No pose is looked for where a
/// difference of volumes alone rules that out. pool: who does the work, with the same result
/// whatever the number of threads.
/// known: of each surface, those byAnchors, which stay whatever the shapes say; or none at all.
std::vector<SurfacePose> findSurfacePoses(const Sequence& sequence, const PropagationTree& tree,
                                          ThreadPool& pool,
                                          const std::vector<SurfacePose>& known = {});

/// A surface that shares three anchors with the root, not on one line, lies where these come
/// closest to the root's (fitRigidWhereShared); of the others nothing is said, they stay as they
/// lie. anchors: of each surface the same number of points, a row of NaN where it lacks one; or
/// none at all.
std::vector<SurfacePose> posesByAnchors(const Sequence& sequence, int root,
                                        const std::vector<Points>& anchors);

/// The sequence with every surface that lies elsewhere laid where it would lie in the root's frame.
Sequence laidInRootsFrame(const Sequence& sequence, const std::vector<SurfacePose>& poses);

}  // namespace sphere_propagation
