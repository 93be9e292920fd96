// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Generalised Procrustes alignment: pose, and size where asked for, are taken out of a set of
/// corresponding shapes. J. C. Gower, Generalized Procrustes analysis, 1975; C. Goodall, Procrustes
/// methods in the statistical analysis of shape, 1991; I. L. Dryden and K. V. Mardia, Statistical
/// shape analysis, 1998, chapter 5 (full Procrustes mean).

#include "vcg_ext/model/training_set.h"

namespace sphere_propagation {

enum class Alignment {
  Similarity,  ///< rotation, translation and scale
  Rigid,       ///< rotation and translation
  None,        ///< the shapes as they are
};

struct ProcrustesParameters {
  Alignment alignment = Alignment::Similarity;
  /// Each landmark weighs a third of the area of the faces around it on the mean shape (which is
  /// computed along), so that dense regions do not count more; else all weigh the same.
  bool areaWeights = false;
  /// Converged when the mean moves by less than this share of its size (root mean square over the
  /// landmarks).
  double tolerance = 1e-13;
  int iterations = 1000;  ///< at most; the share of variance in the size decides how many are
                          ///< needed, usually 5 to 20
};

struct Aligned {
  TrainingSet shapes;      ///< moved, under their names; their average is the mean
  Points mean;             ///< #N by 3
  int iterations = 0;      ///< rounds that were made
  bool converged = false;  ///< whether the tolerance was reached
};

/// Finds for each shape x_i a proper rotation R_i, a translation t_i and, for Similarity, a scale
/// s_i > 0 that minimise
///   sum_i sum_j w_j |s_i R_i x_ij + t_i - m_j|^2,    m the average of the moved shapes,
/// the mean's size being fixed (else all would shrink to a point). Solved by turns: every shape is
/// fitted to the mean (W. Kabsch, 1976; S. Umeyama, 1991), the mean is the average of the fitted
/// shapes, from the first shape on.
///
/// The minimum leaves the frame free. It is fixed so: orientation and centroid are those of the
/// first shape; with Similarity the mean's centroid size, sqrt(sum_j w_j |m_j - centroid|^2), is
/// the average of the shapes' centroid sizes. So eigenvalues do not depend on the pose of any
/// shape, and with Similarity, but for that common unit, on its size.
///
/// Throws ParameterError when a parameter is out of range, or a shape has all its landmarks in one
/// place (Similarity).
Aligned alignShapes(const TrainingSet& shapes, const ProcrustesParameters& parameters = {});

/// The same by the users' own points alone, which only some shapes may have: R_i, t_i and, where
/// `scaled`, s_i > 0 minimise
///   sum_i sum_{k on i} |s_i R_i a_ik + t_i - m_k|^2,   m_k the average of the moved a_ik,
/// and the landmarks follow. anchors: of each shape the same number of points, a row that is not
/// finite where it lacks one. The frame is that of the first shape as it lies; where `scaled`, the
/// average of the aligned landmarks has the centroid size that shapes have on average.
///
/// Solved by turns, as above, from the shape that has the most anchors on; the others join in as
/// soon as three of theirs have a mean.
///
/// Throws ParameterError, which names the shape, where one shares fewer than three anchors with the
/// others, or only such as lie on one line.
Aligned alignByAnchors(const TrainingSet& shapes, const std::vector<Points>& anchors, bool scaled,
                       const ProcrustesParameters& parameters = {});

}  // namespace sphere_propagation
