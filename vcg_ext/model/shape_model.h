// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A statistical shape model: the mean of corresponding shapes and the orthogonal modes in which
/// they vary. T. F. Cootes, C. J. Taylor, D. H. Cooper and J. Graham, Active shape models: their
/// training and application, 1995; step 5 of M. Kirschner and S. Wesarg, Propagation of shape
/// parameterisation for the construction of a statistical shape model of the left ventricle.

#include <limits>
#include <map>
#include <string>
#include <vector>

#include "vcg_ext/base/progress.h"
#include "vcg_ext/model/training_set.h"

namespace sphere_propagation {

/// Shape vectors are x0 y0 z0 x1 y1 z1 ..., as Points lie in memory.
struct ShapeModel {
  Points mean;                  ///< #N by 3
  Triangles faces;              ///< #F by 3
  Eigen::MatrixXd modes;        ///< 3 #N by #M, orthonormal columns, by falling eigenvalue; the
                                ///< first of them where no more were asked for
  Eigen::VectorXd eigenvalues;  ///< #M, variances along the modes: divisor #K - 1, in the unit of
                                ///< length squared
  Eigen::MatrixXd scores;    ///< #K by #M: row k = modes^T (shape k - mean), in the unit of length
  double totalVariance = 0;  ///< sum of all eigenvalues, also of modes that are left out
  std::vector<std::string> names;  ///< of the #K shapes
  std::vector<char> leftOut;       ///< see TrainingSet: the landmarks that the model leaves out
  /// Variance per coordinate of what the modes leave out, where that is known; else 0.
  double noiseVariance = 0;
  /// Landmarks that have a name, as the users' own anchors.
  std::map<std::string, Eigen::Index> landmarkNames = {};

  Eigen::Index modeCount() const { return eigenvalues.size(); }

  /// mean + modes b, for the first b.size() modes.
  Points shape(const Eigen::VectorXd& b) const;
  /// mean + deviations sqrt(eigenvalue) mode: one mode alone, that many standard deviations away.
  Points shape(Eigen::Index mode, double deviations) const;
  /// The same model with the first modes only; all where it has fewer. modeCount >= 0.
  ShapeModel truncated(Eigen::Index modeCount) const;
};

/// Principal component analysis of the shapes as they are (align them first), all modes: #K - 1,
/// fewer where the shapes span less, none where they are identical.
///
/// X = (x_1 - mean, ..., x_K - mean) = U S V^T is taken apart by a thin singular value
/// decomposition; modes U, eigenvalues S^2 / (#K - 1), scores V S. It works on Gram matrices of the
/// shapes, which costs O(#K^2 #N), without squaring the condition (thin_svd.h). Left out are modes
/// whose S is explained by the rounding of coordinates: at most 8 sqrt(#K) epsilon times the
/// largest length of a shape vector. Signs: the entry of largest size in a mode is positive (the
/// first one among such within 1e-6).
///
/// epsilon: the relative precision in which the coordinates were stored; modes: how many columns of
/// `modes` are computed, at most, where no more are wanted; eigenvalues and scores are always all.
ShapeModel buildShapeModel(const TrainingSet& shapes,
                           double epsilon = std::numeric_limits<double>::epsilon(),
                           Eigen::Index modes = std::numeric_limits<Eigen::Index>::max(),
                           const Progress& progress = {});

}  // namespace sphere_propagation
