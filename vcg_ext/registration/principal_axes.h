// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Principal axes of a point cloud, and the scaling of one cloud to the extents of another: step 4a
/// of the paper.

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// What a principal component analysis of points says.
struct PrincipalAxes {
  Vector3 centroid = Vector3::Zero();
  Eigen::Matrix3d axes =
      Eigen::Matrix3d::Identity();      ///< unit columns, the largest variance first, right-handed
  Vector3 variances = Vector3::Zero();  ///< along the axes (divisor #P)
  Vector3 ranges = Vector3::Zero();     ///< largest minus smallest coordinate along each axis
};

/// points: #P by 3, #P >= 1, each counting the same. The signs of the axes mean nothing.
PrincipalAxes principalAxes(const Points& points);

/// Step 4a of the paper: the points scaled along their own principal axes until they extend as far
/// along the k-th of them as the reference does along its k-th, and moved so that the centroids
/// coincide. Nothing is turned. Where either range is nothing (below 1e-9 of the cloud's largest),
/// that axis is not scaled: nothing can be extended to a range, and nothing should be flattened.
/// points: #P by 3, #P >= 1; reference: its axes. Returns #P by 3.
Points scaledToExtents(const Points& points, const PrincipalAxes& reference);

}  // namespace sphere_propagation
