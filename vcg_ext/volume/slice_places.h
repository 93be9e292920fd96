// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Where the slices of a mask lie, each seen from the one before.

#include <utility>
#include <vector>

#include "vcg_ext/volume/grid.h"

namespace sphere_propagation {

/// The convex hull of a slice's voxels, row by row of y; what tells whether slices lie on each
/// other, also where they are open rings.
class SliceHull {
 public:
  SliceHull() = default;
  /// Of at least one voxel.
  explicit SliceHull(std::vector<Eigen::Vector2i> voxels);

  double area() const { return area_; }         ///< voxels
  double common(const SliceHull& other) const;  ///< the area that both have
  void move(const Eigen::Vector2i& by);         ///< voxels

 private:
  int low_ = 0;  // the first row
  std::vector<std::pair<double, double>> rows_;
  double area_ = 0;
};

/// A slice with a label.
struct SlicePlace {
  int slice = 0;                                   ///< z
  Eigen::Vector2i step = Eigen::Vector2i::Zero();  ///< along x, y, from the slice with a label
                                                   ///< before, voxels; of the first 0
  double misfit = 0;   ///< of the outlines after the step: their mean absolute deviation, over the
                       ///< square root of the smaller hull's area
  bool meets = false;  ///< whether much of it, or of the other, lies on a slice beside it
  SliceHull hull;
};

/// Those of a mask, in order. Each is registered to the one before, in whole voxels: its outlines,
/// holes filled, on the signed distance of the other, and the other way round; the mean absolute
/// deviation from the median is least, so that tapering, notches and branches do not count. Slices
/// meet where at least two fifths of the smaller hull lie on the other. Slices that hold a speck
/// alone (fewer than eight voxels, and under a hundredth of the widest slice) are left out.
///
/// Wants slices whose border is outside.
std::vector<SlicePlace> slicePlaces(const Mask& mask);

}  // namespace sphere_propagation
