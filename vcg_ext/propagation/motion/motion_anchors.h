// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Anchors in the fit of a motion: what the user says of where points of the root went.
///
/// Anchor k of surface t adds
///   (A0 / 2) |X_k + B(q_k) c_t - y_kt|^2 / sd^2
/// to what c_t minimises (motion_fit.h), X_k the point of the root, q_k its place on the sphere,
/// B(q_k) the basis there and y_kt the point of the surface. It says where the point is and not how
/// far it moved along the arc, so it does not drift along the tree. Where the anchors contradict
/// the prior, the covariance of that arc is widened by the f >= 1 that explains them best: where
///   log det C(f) + r^T C(f)^-1 r,   C(f) = f (A0 / 2) B Sigma B^T + sd^2 1,
/// of the 3 K numbers r = y - X - B c_s has its first minimum. Where clicks are much better than
/// the prior, that is the mean squared Mahalanobis distance r^T C(1)^-1 r / 3 K; where they are
/// not, as on coarse meshes, the noise is not widened along with the motion.

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "vcg_ext/anchors/anchor_places.h"
#include "vcg_ext/propagation/motion/motion_model.h"
#include "vcg_ext/propagation/motion/motion_prior.h"
#include "vcg_ext/sequence/sequence.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

/// The anchors of one surface.
class LayerAnchors {
 public:
  /// rows: B, 3 K by columns; from: X, to: y, 3 K each; deviation: sd, above 0; unit: A0 / 2.
  LayerAnchors(Eigen::MatrixXd rows, Eigen::VectorXd from, Eigen::VectorXd to, double deviation,
               double unit);

  /// What they add to H.
  const Eigen::MatrixXd& information() const { return information_; }
  /// What they add to the negative gradient at c.
  Eigen::VectorXd pull(const Eigen::VectorXd& c) const;
  /// How much the covariance of the prior is widened on the arc from a surface of coefficients
  /// before.
  double widening(const Eigen::VectorXd& before, const MotionPrior& prior) const;
  /// The step from there that fits prior and anchors alone.
  Eigen::VectorXd step(const Eigen::VectorXd& before, const MotionPrior& prior) const;
  /// How far each anchor lies from where c brings the root's.
  std::vector<double> distances(const Eigen::VectorXd& c) const;
  /// How many standard deviations per coordinate each anchor lies from where the prior and the
  /// other anchors say it is: the Mahalanobis distance, given the others, over sqrt(3). Where at
  /// least two anchors say that the motion is larger than the prior expects, their spread counts:
  /// all is over sqrt(max(1, median of the squares / 0.789)).
  std::vector<double> standardised(const Eigen::VectorXd& before, const MotionPrior& prior) const;
  /// Those whose names are exchanged in all likelihood, two or more in turn: each has the place of
  /// the next one, the last that of the first. With y as they should be then, the criterion above,
  /// at its f, is lower by more than 20 (odds of e^10). Looked at are all pairs, and the cycles of
  /// the names that lie nearest, all together, to where c brings the root's; of those that share
  /// an anchor, the better one; each with its smallest number first.
  std::vector<std::vector<int>> exchanged(const Eigen::VectorXd& before,
                                          const MotionPrior& prior) const;

 private:
  Eigen::VectorXd residual(const Eigen::VectorXd& c) const { return to_ - from_ - rows_ * c; }
  /// C(1) without the noise.
  Eigen::MatrixXd priorCovariance(const MotionPrior& prior) const;

  Eigen::MatrixXd rows_, information_;
  Eigen::VectorXd from_, to_;
  double weight_, deviation_, unit_;
};

/// Those of all surfaces.
class MotionAnchors {
 public:
  MotionAnchors() = default;
  /// places: on the surfaces of the sequence; root: its number, and its map. deviations: sd of each
  /// surface.
  MotionAnchors(const MotionModel& model, const Sequence& sequence, int root,
                const MappedSurface& map, const AnchorPlaces& places,
                const std::vector<double>& deviations);

  /// Also where none but the root has any: these say nothing.
  bool empty() const { return layers_.empty(); }
  /// Nothing where the surface has none, and for the root.
  const LayerAnchors* of(size_t layer) const {
    return layer < layers_.size() && layers_[layer] ? &*layers_[layer] : nullptr;
  }

 private:
  std::vector<std::optional<LayerAnchors>> layers_;
};

}  // namespace sphere_propagation
