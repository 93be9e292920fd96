// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Shapes that do not belong, in another unit, with landmarks in another order, or mirrored, and
/// single landmarks that do not.

#include <vector>

#include "vcg_ext/model/training_set.h"

namespace sphere_propagation {

struct Outlier {
  enum class Kind { Size, Shape, Landmarks };
  size_t shape = 0;  ///< its number in the set
  Kind kind = Kind::Shape;
  /// Size: its centroid size over the median one; Shape: its distance from the median shape over
  /// that of most shapes; Landmarks: the same of `distance`.
  double ratio = 1;
  /// In the unit of length; Shape: root mean square over the landmarks; Landmarks: of the first of
  /// them from where its neighbours say that it is.
  double distance = 0;
  double units = 0;  ///< Size: the ratio of two units that `ratio` is close to, see unit_ratio.h
  std::vector<int> landmarks = {};  ///< Landmarks: which, the farthest off first
};

/// In the order of the shapes, each at most once: size first, landmarks last.
///
/// Measured against the third quartile of the same figure over all shapes, so that a quarter of
/// them may be outliers. A normal population, even one with a single mode and of thousands of
/// shapes, stays below 3 times that.
///   Size: more than 4 times as far from the median (in logarithms), and by a factor of 1.8 at
///   least. Where sizes come in groups, with nothing between them over a factor of 3 or more,
///   figures are those of the largest group (of equals that of the lowest number), without others
///   that differ from it as units do (unit_ratio.h): these stand out.
///   Shape: the distance from the median shape (coordinate by coordinate), in the size that fits it
///   best, is more than 4 times as large and 2 % of the shape's size (root mean square distance
///   from its centroid) at least; or more than twice the median distance and half that size, which
///   no two shapes of one organ are apart, so that up to half of the shapes may be such.
///   Landmarks: where one lies, seen from the six that are nearest to it in the median shape,
///   differs from what it does there by more than 6 times as much, 10 % of the shape's size, and 8
///   times as much as those six do themselves, the farthest not counted: on real skulls, whose
///   beaks differ by more than their length, that is at most 5.4.
/// Fewer than 5 shapes have none.
///   Up to 10 of a shape that is of the usual size without them are named in place of the shape.
///
/// given: as they came; aligned: the same, aligned (alignShapes).
std::vector<Outlier> findOutliers(const TrainingSet& given, const TrainingSet& aligned);

/// For each shape the first one that is the same to 1e-5 of its size, once aligned; -1: there is
/// none.
std::vector<int> repeatedShapes(const TrainingSet& aligned);

}  // namespace sphere_propagation
