// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Where things are shown side by side, so that none hides another.

#include <Eigen/Geometry>
#include <vector>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// The box of points, as far as they are finite.
Eigen::AlignedBox3d boxOf(const Points& points);

/// A place in a grid: cells to the right of its first column, and below its first row.
struct GridCell {
  double column = 0, row = 0;
};

/// Places in a grid as MeshLab looks at the scene (along -z, x to the right, y upwards): by how
/// much each box is to be moved. Cells are as large as the largest box and a margin. `cells` says
/// which each box takes; where it is empty, boxes stand in reading order, so many in a row that the
/// grid is about as wide as it is high, and an empty box takes no cell. The grid stands to the
/// right of `beside`, centred on it in y and z; where that is empty, it is centred on all boxes
/// together. An empty box stays where it is.
std::vector<Vector3> sideBySide(const std::vector<Eigen::AlignedBox3d>& boxes,
                                const Eigen::AlignedBox3d& beside = {},
                                const std::vector<GridCell>& cells = {});

}  // namespace sphere_propagation
