// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Where on a surface a model may lie: poses to start a fit from.

#include <vector>

#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/fitting/fitting_model.h"
#include "vcg_ext/fitting/fitting_target.h"
#include "vcg_ext/registration/rigid_alignment.h"

namespace sphere_propagation {

struct StartPose {
  RigidMotion motion;  ///< of the model's frame onto the surface
  double misfit = 0;   ///< mean of the smaller distances of the surface's samples from the mean
};

/// The 60 rotations of the icosahedron, the first of which is none, about the centre: centres lie
/// on each other. For whole surfaces, whose size may be another than the mean's.
std::vector<RigidMotion> turnsAboutCentre(const FittingModel& model, const FittingTarget& target);

/// Trimmed fits of some samples of the surface onto the mean shape (70 % of them, point to plane;
/// D. Chetverikov, D. Stepanov and P. Krsek, Robust Euclidean alignment of 3D point sets, 2005),
/// from the 60 rotations of the icosahedron: no rotation is farther than 45 degrees from all of
/// them. The first is what comes of no turn, then those that differ from it and each other, best
/// first, at most `keep` in all. A part of a surface lies on the whole this way round, which the
/// whole on a part would not.
std::vector<StartPose> startPoses(const FittingModel& model, const FittingTarget& target, int keep,
                                  ThreadPool& pool);

}  // namespace sphere_propagation
