// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Holes in the slices of a mask: what makes a wall a ring.

#include <vector>

#include "vcg_ext/volume/grid.h"

namespace sphere_propagation {

/// The holes of each slice z: voxels outside that the slice's inside voxels separate from its
/// border (outside voxels hang together through faces).
class SliceHoles {
 public:
  /// Wants slices whose border is outside.
  explicit SliceHoles(const Mask& mask);

  const Mask& holes() const { return holes_; }
  const Mask& filled() const { return filled_; }  ///< the mask and its holes
  bool any() const;
  bool has(int slice) const { return !sizes_[static_cast<size_t>(slice)].empty(); }

  /// Whether the holes of two slices lead from one to the other or are closed by it, so that the
  /// wall between the slices is what lies between its outer and its inner surface. A hole leads on
  /// where it overlaps a hole of the other slice; it is closed where what fills the other slice
  /// lies over half of it, or half of what fills the slice over it. False where neither slice has
  /// holes, or where more than a tenth of their area opens to the side.
  bool leadThrough(int a, int b) const;

 private:
  long opened(int from, int to) const;

  Mask holes_, filled_;
  std::vector<int> component_;  // of a voxel in a hole: its number in the slice, from 0; else -1
  std::vector<std::vector<long>> sizes_;  // of each slice's holes
  std::vector<long> filledSizes_;         // voxels of each slice of filled_
};

}  // namespace sphere_propagation
