// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The way through several shapes that correspond, as weights of these shapes.

#include <Eigen/Core>

namespace sphere_propagation {

enum class MorphPath {
  Linear,      ///< straight from each shape to the next
  ShapeModel,  ///< smooth through all of them: a cubic spline of the scores of their shape model
};

/// The weights (#K, of sum 1) with which #K shapes add up to the one at `time`: shape k at time k.
///
/// ShapeModel: with all modes of a model of these shapes, as they lie, shape k is mean + modes b_k
/// without remainder. So the shape of spline scores b(t) = sum_k w_k(t) b_k is sum_k w_k(t) shape
/// k, w the cardinal splines: natural ones, or periodic ones of period #K where the way is closed.
/// The model itself need not be built. Of two shapes it is the straight line, closed or not.
///
/// count: at least 1; time: 0 to count - 1, closed to count.
Eigen::VectorXd pathWeights(MorphPath path, bool closed, int count, double time);

}  // namespace sphere_propagation
