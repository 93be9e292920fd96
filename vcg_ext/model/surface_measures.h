// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// How good a shape model is, measured between surfaces: measures between landmarks
/// (model_measures.h) reward landmarks that gather where that makes shapes look alike, distances
/// between surfaces do not. R. H. Davies, C. Twining and C. Taylor, Statistical models of shape:
/// optimisation and evaluation, 2008 (chapter 9: measures by landmarks mislead); A. Ericsson and J.
/// Karlsson, Measures for benchmarking of automatic correspondence algorithms, 2007.

#include <vector>

#include "vcg_ext/base/progress.h"
#include "vcg_ext/model/shape_model.h"

namespace sphere_propagation {

struct SurfaceMeasureParameters {
  static constexpr int maxSamples = 100'000;

  int modes = 10;     ///< models of 1 to so many modes are measured, at least 0
  int points = 400;   ///< of each surface, spread evenly over its area
  int samples = 100;  ///< shapes drawn for the specificity, 1 to maxSamples
  int leftOut = 100;  ///< shapes that are left out one by one, at most: evenly spread over the list
  unsigned seed = 0;  ///< of the draws
  int threads = 0;    ///< 0: as many as the machine runs at once; the figures are the same with any
};

/// The surface that a shape was sampled from.
struct SampledSurface {
  Points vertices;  ///< #V by 3
  Triangles faces;  ///< #F by 3, those that the model is to describe
};

/// d(A, B) is the mean distance of points of A, evenly spread by area, from the closest of B, and
/// the other way round, averaged: in the unit of length.
struct SurfaceMeasures {
  /// Entry m - 1, with m modes: mean over the shapes i of d(surface of x_i, x'_i(m)), x'_i(m) the
  /// best approximation of the landmarks x_i by m modes of the model of all other shapes
  /// (leave_one_out.h), as a mesh.
  Eigen::VectorXd generalisation;
  /// Entry m - 1: mean over samples y of the model of m modes of min_i d(y, surface of x_i), i
  /// among the three whose surfaces an eighth of y's points are the nearest to.
  Eigen::VectorXd specificity;
  Eigen::VectorXd generalisationError, specificityError;  ///< standard errors of the means
  /// Of each shape: d(its surface, its landmarks as a mesh). What lies between the landmarks is
  /// lost; where landmarks gathered, this grows.
  Eigen::VectorXd offSurface;
  /// Of each shape: faces of its landmark mesh that look against the surface below their centre.
  Eigen::VectorXi foldedFaces;
};

/// model: with all its modes and scores, as buildShapeModel makes it; shapes: as they were before
/// they were aligned, in the order of the model's scores, and aligned: afterwards; the surfaces are
/// moved along with their landmarks. surfaces: one per shape, as it lies before. Throws
/// ParameterError when a parameter is out of range.
SurfaceMeasures measureSurfaces(const ShapeModel& model, const TrainingSet& shapes,
                                const TrainingSet& aligned,
                                const std::vector<SampledSurface>& surfaces,
                                const SurfaceMeasureParameters& parameters = {},
                                const Progress& progress = {});

}  // namespace sphere_propagation
