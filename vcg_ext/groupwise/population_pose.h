// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The frame that a population is looked at in: its shapes aligned, and their mean.

#include <vector>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/model/procrustes.h"

namespace sphere_propagation {

struct PopulationPose {
  std::vector<Eigen::Matrix3d> turns;  ///< one per shape: rotation times scale
  std::vector<Points> shapes;          ///< aligned landmarks, #N by 3
  Points mean;                         ///< #N by 3
  Eigen::VectorXd weights;  ///< #N: the share of each landmark in the shapes' area, sum 1

  /// The mean of the squared distances from the mean shape, weighted: the total variance (divisor
  /// K).
  double variance() const;
};

/// Generalised Procrustes alignment with area weights (procrustes.h). landmarks: two or more shapes
/// of #N by 3; faces: of the landmarks.
PopulationPose poseOf(const std::vector<Points>& landmarks, const Triangles& faces,
                      Alignment alignment);

}  // namespace sphere_propagation
