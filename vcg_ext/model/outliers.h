// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Shapes that do not belong: landmarks in another order, another unit, a mirror image.

#include <vector>

#include "vcg_ext/model/training_set.h"

namespace sphere_propagation {

struct Outlier {
  enum class Kind { Size, Shape };
  size_t shape = 0;  ///< its number in the set
  Kind kind = Kind::Shape;
  /// Size: its centroid size over the median one; Shape: its distance from the median shape over
  /// that of most shapes.
  double ratio = 1;
  double distance = 0;  ///< Shape: root mean square over the landmarks, in the unit of length
  double units = 0;     ///< Size: the ratio of two units that `ratio` is close to, see unit_ratio.h
};

/// In the order of the shapes, each at most once, size first.
///
/// Measured against the third quartile of the same figure over all shapes, so that a quarter of
/// them may be outliers. A normal population, even one with a single mode and of thousands of
/// shapes, stays below 3 times that.
///   Size: more than 4 times as far from the median (in logarithms), and by a factor of 1.8 at
///   least. Where sizes come in two groups, with nothing between them over a factor of 3 or more,
///   and differ as units do (unit_ratio.h), the smaller group stands out, of equals that without
///   the first shape; and figures are those of the larger one.
///   Shape: the distance from the median shape (coordinate by coordinate), in the size that fits it
///   best, is more than 4 times as large and 2 % of the shape's size (root mean square distance
///   from its centroid) at least; or more than twice the median distance and half that size, which
///   no two shapes of one organ are apart, so that up to half of the shapes may be such.
/// Fewer than 5 shapes have none.
///
/// given: as they came; aligned: the same, aligned (alignShapes).
std::vector<Outlier> findOutliers(const TrainingSet& given, const TrainingSet& aligned);

}  // namespace sphere_propagation
