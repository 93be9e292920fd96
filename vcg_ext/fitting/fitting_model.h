// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A shape model made ready to be fitted: its modes, and a local deformation that stands for what
/// its few training shapes cannot show.
///
/// Landmark j of a shape in the model's frame lies at
///   x_j = m_j + U_j b + L_j a,    b ~ N(0, diag(eigenvalues)),  a ~ N(0, s^2),
/// m and U the mean and the modes; L 60 columns a coordinate of a Gaussian kernel of length 0.35 R
/// over the mean, R the radius of a sphere of its area (pivoted Cholesky, pivots by area); s the
/// local deviation. As M. Luethi, T. Gerig, C. Jud and T. Vetter, Gaussian process morphable
/// models, 2018, add a kernel to the covariance of a shape model.

#include <limits>
#include <optional>

#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/model/shape_model.h"

namespace sphere_propagation {

struct FittingModelParameters {
  Eigen::Index modes = std::numeric_limits<Eigen::Index>::max();  ///< the first so many, at most
  /// s, in the unit of length; 0: shapes have nothing local. Empty: it is learnt.
  std::optional<double> localDeviation = {};
};

/// How many training shapes it can be learnt from.
constexpr Eigen::Index minShapesToLearnFrom = 3;

/// Root mean square, per coordinate, of what the first modes of the models of all shapes but one
/// leave of that one (leave_one_out.h). Empty where the model has no scores of
/// minShapesToLearnFrom.
std::optional<double> learntLocalDeviation(const ShapeModel& model, Eigen::Index modes,
                                           ThreadPool& pool);

/// What is taken where nothing can be learnt: the model's noise, and where that is not known as if
/// 5 % of the variance were missing.
double assumedLocalDeviation(const ShapeModel& model);

/// Whether size was taken out of the training shapes (Alignment::Similarity): then the fit of each
/// to the mean has scale 1, <x_k, m> / <x_k, x_k> is the same for all, to 0.1 %. False where the
/// model has no scores.
bool isWithoutSize(const ShapeModel& model);

class FittingModel {
 public:
  static constexpr int pivots = 60;

  /// model: with faces. The local deviation is learnt, or else assumed. Throws ParameterError when
  /// a parameter is out of range or the mean shape has no area.
  FittingModel(const ShapeModel& model, ThreadPool& pool,
               const FittingModelParameters& parameters = {});

  const Points& mean() const { return mean_; }
  const Triangles& faces() const { return faces_; }
  double radius() const { return radius_; }  ///< R
  double localDeviation() const { return localDeviation_; }
  Eigen::Index modeCount() const { return modes_.cols(); }
  /// Modes first, then the local ones.
  Eigen::Index columnCount() const { return variances_.size(); }
  /// Of each coefficient, a priori.
  const Eigen::VectorXd& variances() const { return variances_; }

  /// The landmarks for these coefficients (the first c.size() columns), #N by 3.
  Points shape(const Eigen::VectorXd& c) const;
  /// Adds weight (U_j, L_j)^T n to the first columns of a row.
  void project(Eigen::Index landmark, const Vector3& n, double weight,
               Eigen::Ref<Eigen::RowVectorXd> row) const;

 private:
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  Points mean_;
  Triangles faces_;
  double radius_ = 0, localDeviation_ = 0;
  Rows modes_;  // 3 #N by #M
  Rows local_;  // #N by `pivots`
  Eigen::VectorXd variances_;
};

}  // namespace sphere_propagation
