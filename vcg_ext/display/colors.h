// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The type of lists of colours.

#include <Eigen/Core>

namespace sphere_propagation {

/// #N by 3 list of red, green, blue.
using Colors = Eigen::Matrix<unsigned char, Eigen::Dynamic, 3, Eigen::RowMajor>;

}  // namespace sphere_propagation
