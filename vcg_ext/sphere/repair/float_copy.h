// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The copy of a map that a host of single precision keeps: unit vectors as floats.

#include <Eigen/Core>

#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

struct FloatCopy {
  /// #V by 3.
  Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> positions;
  /// Vertices moved by a few units in the last place because rounding had flipped a face.
  int mendedVertices = 0;
  /// Whether these floats certify as a map. If not, they should not be kept.
  bool valid = false;
};

/// Rounds a map to float and mends what the rounding flipped.
FloatCopy copyToFloat(const MappedSurface& map);

}  // namespace sphere_propagation
