// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Copies of a map in single precision: the unit vectors that some hosts keep, and the texture
/// coordinates that files keep. What rounding flips is mended in them.

#include <Eigen/Core>

#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

template <int Columns>
struct FloatCopy {
  using Numbers = Eigen::Matrix<float, Eigen::Dynamic, Columns, Eigen::RowMajor>;
  /// #V by 3 positions, or #V by 2 texture coordinates (u, v) as in sphere_coordinates.h.
  Numbers numbers;
  /// Vertices moved by a few units in the last place because rounding had flipped a face.
  int mendedVertices = 0;
  /// Whether the positions that these floats stand for certify as a map. If not, they should not be
  /// kept.
  bool valid = false;
};
using PositionCopy = FloatCopy<3>;
using TextureCopy = FloatCopy<2>;

/// Round a map, and make it a valid one again where that takes small moves: each vertex of a face
/// that is flipped or too small goes to the floats nearby that leave the smallest face around it
/// largest, in a few rounds.
PositionCopy copyToFloat(const MappedSurface& map);
TextureCopy copyToTexture(const MappedSurface& map);

/// The positions that float texture coordinates stand for (not certified): #V by 3.
Points positionsFromTexture(const TextureCopy::Numbers& coordinates);

}  // namespace sphere_propagation
