// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Method Robust: the root's motion, followed through all surfaces (motion_propagation.h). A
/// surface that this loses comes from its parent, aligned (aligned_propagation.h), and where no map
/// comes of that either, as published (published_propagation.h): shapes that differ much, of which
/// the published steps smooth all, and so reach a valid map more often.

#include "vcg_ext/propagation/motion/motion_propagation.h"
#include "vcg_ext/propagation/strategy.h"

namespace sphere_propagation {

/// Surfaces whose sizes differ from their parents' by more than this are refused.
constexpr double maxRelativeSize = 100;

class RobustStrategy : public PropagationStrategy {
 public:
  explicit RobustStrategy(const MotionParameters& parameters) : parameters_(parameters) {}
  /// Surfaces of another size than the rest are taken in the root's (surface_sizes.h), and those in
  /// another pose are laid in the root's frame for it (surface_poses.h).
  /// Throws, besides, ParameterError where a surface is of another size than its parent by more
  /// than maxRelativeSize.
  Propagation propagate(const PropagationTask& task, const Progress& progress) const override;

 private:
  MotionParameters parameters_;
};

}  // namespace sphere_propagation
