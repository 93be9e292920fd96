// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/model_measures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/random.h"
#include "vcg_ext/model/thin_svd.h"

namespace sphere_propagation {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Mean and standard error of values that come one by one, for several modes at once.
class Statistics {
 public:
  explicit Statistics(Eigen::Index modes)
      : mean_(Vector::Zero(modes)), squares_(Vector::Zero(modes)) {}
  void add(const Vector& values) {  // B. P. Welford, 1962
    ++count_;
    const Vector difference = values - mean_;
    mean_ += difference / count_;
    squares_ += difference.cwiseProduct(values - mean_);
  }
  const Vector& mean() const { return mean_; }
  Vector error() const {
    if (count_ < 2) return Vector::Zero(mean_.size());
    return (squares_ / count_ / (count_ - 1)).cwiseSqrt();
  }

 private:
  double count_ = 0;
  Vector mean_, squares_;
};

/// Distances of one shape from its approximations by 1 to `modes` modes of the model of the others.
Vector leaveOneOut(const Matrix& scores, Eigen::Index left, Eigen::Index modes) {
  const Eigen::Index others = scores.rows() - 1;
  Matrix rest(scores.cols(), others);
  rest.leftCols(left) = scores.topRows(left).transpose();
  rest.rightCols(others - left) = scores.bottomRows(others - left).transpose();
  const Vector mean = rest.rowwise().mean();
  rest.colwise() -= mean;
  Vector residual = scores.row(left).transpose() - mean;

  const ThinSvd svd = thinSvd(rest);
  const Vector& s = svd.s;
  // What the rounding of the scores explains is no mode.
  const double rounding =
      static_cast<double>(scores.rows()) * std::numeric_limits<double>::epsilon() * scores.norm();
  Vector distances(modes);
  for (Eigen::Index m = 0; m < modes; ++m) {
    if (m < std::min(s.size(), others - 1) && s[m] > rounding)
      residual -= svd.u.col(m) * svd.u.col(m).dot(residual);
    distances[m] = residual.norm();
  }
  return distances;
}

/// Squared distances of the shapes from their own approximations by the first 1 to `modes` modes,
/// #K by modes.
Matrix squaredTails(const Matrix& scores, Eigen::Index modes) {
  Matrix tails(scores.rows(), modes);
  for (Eigen::Index m = 0; m < modes; ++m)
    tails.col(m) = scores.rightCols(scores.cols() - m - 1).rowwise().squaredNorm();
  return tails;
}

}  // namespace

ModelMeasures measureModel(const ShapeModel& model, Eigen::Index modes,
                           const ModelMeasureParameters& parameters, const Progress& progress) {
  requireRange("number of samples for the specificity", parameters.samples,
               Range::between(1, ModelMeasureParameters::maxSamples));
  requireRange("number of modes", static_cast<double>(modes), Range::atLeast(0));
  modes = std::min(modes, model.modeCount());
  const double perLandmark = 1 / std::sqrt(static_cast<double>(model.mean.rows()));

  ModelMeasures measures;
  measures.compactness.resize(modes);
  double sum = 0;
  for (Eigen::Index m = 0; m < modes; ++m) measures.compactness[m] = sum += model.eigenvalues[m];

  const Eigen::Index shapes = model.scores.rows();
  Statistics generalisation(modes);
  for (Eigen::Index k = 0; k < shapes && modes > 0; ++k) {
    generalisation.add(perLandmark * leaveOneOut(model.scores, k, modes));
    report(progress, 0.8 * static_cast<double>(k + 1) / static_cast<double>(shapes));
  }
  measures.generalisation = generalisation.mean();
  measures.generalisationError = generalisation.error();

  const Matrix tails = squaredTails(model.scores, modes);
  std::mt19937_64 bits(parameters.seed);
  Statistics specificity(modes);
  Vector heads(shapes), distances(modes);
  for (int sample = 0; sample < parameters.samples && modes > 0; ++sample) {
    heads.setZero();
    for (Eigen::Index m = 0; m < modes; ++m) {
      const double b = normalNumbers(bits)[0] * std::sqrt(model.eigenvalues[m]);
      heads += (model.scores.col(m).array() - b).square().matrix();
      distances[m] = perLandmark * std::sqrt((heads + tails.col(m)).minCoeff());
    }
    specificity.add(distances);
  }
  measures.specificity = specificity.mean();
  measures.specificityError = specificity.error();
  report(progress, 1);
  return measures;
}

}  // namespace sphere_propagation
