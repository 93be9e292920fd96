// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A shape model fitted to a surface: the posterior of its shape and pose, given what is seen.
///
/// The shape is seen as y_j = s R x_j + t (fitting_model.h). Observed are pairs of a point y on the
/// model, with the model's normal n there, and a point p of the surface: of each landmark the
/// closest point of the surface, and of points spread over the surface the closest one of the
/// model; none where normals disagree or the closest point lies at the edge of an open surface.
/// Each says
///   n . (y - p) ~ N(0, T sigma^2 / w),
/// sigma from the median of the residuals, w = (1 + (r / 3 sigma)^2)^-2 (S. Geman and D. E.
/// McClure, 1987), T how many observations are worth an independent one, as misfits are smooth.
/// Pose and coefficients are solved for together by Gauss-Newton; where it ends, they are normal,
/// with
///   C = (sum w g g^T / (T sigma^2) + diag(0, 1 / variances))^-1,    g = dy/d(pose, c) . n,
/// and landmark j has the covariance J_j C J_j^T: wide along the surface, and where nothing was
/// seen.
///
/// The pose: trimmed fits of the mean, point to plane, from 60 rotations, and with the modes for
/// two steps the same rotations of a whole surface, or where those fits of a part ended; the best
/// of both are continued with the modes, and the one of the largest posterior goes on; of some that
/// are about as likely, as where a shape looks like itself from two sides, the least turned.

#include <optional>
#include <vector>

#include "vcg_ext/base/progress.h"
#include "vcg_ext/fitting/fitting_model.h"
#include "vcg_ext/fitting/fitting_target.h"
#include "vcg_ext/registration/rigid_alignment.h"

namespace sphere_propagation {

/// A point that is known: landmark j lies at `point`, with this standard deviation a coordinate.
struct FittingAnchor {
  Eigen::Index landmark = 0;
  Vector3 point = Vector3::Zero();
  double deviation = 1;  ///< unit of length, above 0
};

/// How many anchors tell a pose.
constexpr size_t minPoseAnchors = 3;

struct ModelFitParameters {
  /// Where the model's frame lies, to begin with; empty: searched for, or from the anchors where
  /// there are three of them.
  std::optional<RigidMotion> pose = RigidMotion{};
  double scale = 1;     ///< s at that pose, above 0
  bool scales = false;  ///< whether s is sought; else it stays
  std::vector<FittingAnchor> anchors = {};
  int iterations = 12;  ///< at most, 1 to 1000
  int starts = 16;  ///< poses that are continued by a search, of a part a quarter more; 2 to 120
  /// What standard deviations are multiplied by: fit_calibration.h.
  double calibration = 1;
  /// Only every so many-th landmark and sample is observed, and only these landmarks get a
  /// covariance; those of the others are 0.
  int thinning = 1;
  double meanEdge = 0;  ///< of which the noise is 5 % at least; 0: that of the target
};

struct ModelFit {
  Points landmarks;                                        ///< #N by 3, in the surface's frame
  std::vector<Eigen::Matrix3d> covariance;                 ///< of each landmark
  Eigen::VectorXd scores;                                  ///< b
  Eigen::VectorXd local;                                   ///< a, three a pivot
  Eigen::VectorXd scoreDeviations;                         ///< standard deviations of the scores
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< R
  double scale = 1;                                        ///< s
  Vector3 translation = Vector3::Zero();                   ///< t
  double noise = 0;                                        ///< sigma, in the unit of length
  double surfaceDistance = 0;  ///< mean, of the surface's samples from the closest point of the fit
  double unseen = 0;           ///< share of the landmarks that no part of the surface is near to
  double unexplained = 0;      ///< share of the samples that no part of the model is near to
  /// Of shape and pose, but for a constant: with one noise for all, so that fits of the same model
  /// can be compared.
  double logPosterior = 0;
  int starts = 1;  ///< poses that the fit was tried from

  /// From the model's frame to the surface's.
  Eigen::Matrix4d pose() const;
  /// Of each landmark: the square root of the mean variance of its coordinates.
  Eigen::VectorXd deviations() const;
};

/// pool: who does the work, with the same result whatever the number of threads. Throws
/// ParameterError where a parameter is out of range, SurfaceError where no part of the model comes
/// near any of the surface.
ModelFit fitModel(const FittingModel& model, const FittingTarget& target, ThreadPool& pool,
                  const ModelFitParameters& parameters = {}, const Progress& progress = {});

/// To fit once more, for its posterior alone: from where `fit` brought the model, to a part of the
/// landmarks (250) and samples.
ModelFitParameters onceMoreFrom(const ModelFit& fit, const FittingModel& model,
                                ModelFitParameters parameters);

}  // namespace sphere_propagation
