// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The description length of a population, which says how few numbers tell all of its shapes.

#include <Eigen/Core>

#include "vcg_ext/groupwise/population_pose.h"

namespace sphere_propagation {

/// The sum over the eigenvalues l of the covariance of 1 + ln(l / cut) where l is above the cut, l
/// / cut elsewhere (H. H. Thodberg, 2003). Landmarks weigh by their area (T. Heimann et al., 2005),
/// so that to crowd where shapes do not vary gains nothing.
struct DescriptionLength {
  double cost = 0;
  /// K by K, positive semi-definite: the cost changes as half of trace(pull dG), G the Gram matrix
  /// of the displacements from the mean. Rows and columns add up to zero.
  Eigen::MatrixXd pull;
};

/// pose: in units of the shapes' radius; cut: the variance that counts as noise, in the same.
DescriptionLength descriptionLengthOf(const PopulationPose& pose, double cut);

}  // namespace sphere_propagation
