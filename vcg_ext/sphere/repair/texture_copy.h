// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The copy of a map that files keep: texture coordinates, which every host stores as float.

#include <Eigen/Core>

#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

struct TextureCopy {
  /// #V by 2 texture coordinates (u, v) as in sphere_coordinates.h.
  Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor> coordinates;
  /// Vertices moved by a few units in the last place because rounding had flipped a face.
  int mendedVertices = 0;
  /// Whether the positions that these floats stand for certify as a map. If not, only the map
  /// itself should be kept.
  bool valid = false;
};

/// Rounds a map to float texture coordinates and mends what the rounding flipped.
TextureCopy copyToTexture(const MappedSurface& map);

/// The positions that float texture coordinates stand for (not certified): #V by 3.
Points positionsFromTexture(
    const Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor>& coordinates);

}  // namespace sphere_propagation
