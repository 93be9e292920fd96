// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What a surface says of where the nodes of a motion model are: the data term of motion_fit.h.

#include <Eigen/Core>
#include <vector>

#include "vcg_ext/propagation/motion/motion_model.h"
#include "vcg_ext/registration/prepared_surface.h"

namespace sphere_propagation {

/// One entry or row per node. Nodes with whose normal no face of the surface agrees have weight 0.
struct MotionData {
  Points nodes;             ///< x_i
  Eigen::VectorXd weights;  ///< A_i w_i (A0/2) / At^2: kappa is taken for 1
  Points directions;        ///< m_i
  Eigen::VectorXd offsets;  ///< m_i . (p_i - x_i)
  Points pull;              ///< weight, offset and direction multiplied
  double distance = 0;      ///< mean, of the nodes with which a face agrees; NaN: none
};

/// The data term at coefficients c. nearby: for each node a face of the surface to look at first,
/// -1 where there is none; the closest ones on return.
MotionData motionDataAt(const MotionModel& model, const PreparedSurface& target,
                        const Eigen::VectorXd& c, std::vector<int>& nearby);

}  // namespace sphere_propagation
