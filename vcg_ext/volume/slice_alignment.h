// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Slices that do not meet, as after another breath, and how far each has to be moved back.

#include <vector>

#include "vcg_ext/volume/grid.h"

namespace sphere_propagation {

/// A slice that is to be moved in its plane.
struct SliceShift {
  int slice = 0;                                     ///< z
  Eigen::Vector2i voxels = Eigen::Vector2i::Zero();  ///< along x, y; to be added to what is there
  bool alone = false;  ///< whether the slice hardly meets the slices beside it
};

/// How the slices z of a mask are to be moved so that the stack is smooth, those that stay left
/// out.
///
/// Where a slice lies: each is registered to the one before, in whole voxels (its outlines, holes
/// filled, on the signed distance of the other, and the other way round; the mean absolute
/// deviation from the median is least, so that tapering, notches and branches do not count). Where
/// it should lie: the trend of these places, by Whittaker smoothing with third differences (P. H.
/// C. Eilers, A perfect smoother, Analytical Chemistry 75, 2003) and Tukey's weights, so that a
/// bend costs nothing and a slice that stands out does not pull; the smoothness follows from the
/// noise that third differences show. Slices that hardly meet those beside them (less than two
/// fifths of the smaller one overlap) have no weight.
///
/// A slice is moved towards the trend, by no more than to the middle of the slices beside it. The
/// first and the last one are moved only where they hardly meet the next: nothing else tells a
/// shift from a bend. In a stack that is smooth (noise below `smoothNoise`) shifts below `least` do
/// not count;
/// and the slice next to the first or last is moved only where that one lies near the straight line
/// through the third and fourth: else it may be the one that bends away.
///
/// spacing: along x, y, z, mm. Wants slices whose border is outside. Fewer than three slices with a
/// label, or slices close to each other, tell nothing.
std::vector<SliceShift> findSliceShifts(const Mask& mask, const Vector3& spacing);

/// In mm, for findSliceShifts.
struct SliceAlignmentLimits {
  static constexpr double smoothNoise = 1.75;
  static constexpr double least = 3;
};

/// Moves slices; the mask grows by what it takes for its border to stay as wide as it was. Returns
/// by how many voxels it grew at the low end of x and y.
Eigen::Vector2i moveSlices(Mask& mask, const std::vector<SliceShift>& shifts);

}  // namespace sphere_propagation
