// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/model_measures.h"

#include <algorithm>
#include <cmath>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/random.h"
#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/model/leave_one_out.h"

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

/// Squared distances of the shapes from their own approximations by the first 1 to `modes` modes,
/// #K by modes.
Matrix squaredTails(const Matrix& scores, Eigen::Index modes) {
  Matrix tails(scores.rows(), modes);
  Vector tail = scores.rightCols(scores.cols() - modes).rowwise().squaredNorm();
  for (Eigen::Index m = modes - 1; m >= 0; --m) {
    tails.col(m) = tail;
    tail += scores.col(m).cwiseAbs2();
  }
  return tails;
}

/// Distances of samples to the nearest shape, one sample per column, by number of modes. A column
/// of the scores serves all samples while it is at hand.
///
/// normals: modes by samples.
void nearestShapes(const ShapeModel& model, const Matrix& tails, const Matrix& normals,
                   Eigen::Ref<Matrix> distances) {
  Matrix heads = Matrix::Zero(tails.rows(), normals.cols());
  for (Eigen::Index m = 0; m < normals.rows(); ++m)
    for (Eigen::Index sample = 0; sample < normals.cols(); ++sample) {
      const double b = normals(m, sample) * std::sqrt(model.eigenvalues[m]);
      heads.col(sample) += (model.scores.col(m).array() - b).square().matrix();
      distances(m, sample) = std::sqrt((heads.col(sample) + tails.col(m)).minCoeff());
    }
}

void measureSpecificity(const ShapeModel& model, Eigen::Index modes,
                        const ModelMeasureParameters& parameters, ThreadPool& pool,
                        const Progress& progress, ModelMeasures& measures) {
  constexpr int together = 8, tasks = 16;  // samples of a task, tasks between two reports
  const Matrix tails = squaredTails(model.scores, modes);
  const double perLandmark = 1 / std::sqrt(static_cast<double>(model.mean.rows()));
  std::mt19937_64 bits(parameters.seed);
  Statistics specificity(modes);
  for (int begin = 0; begin < parameters.samples; begin += together * tasks) {
    const int count = std::min(together * tasks, parameters.samples - begin);
    Matrix normals(modes, count), distances(modes, count);
    for (int sample = 0; sample < count; ++sample)
      for (Eigen::Index m = 0; m < modes; ++m) normals(m, sample) = normalNumbers(bits)[0];
    pool.forEach((count + together - 1) / together, [&](int task) {
      const int first = task * together, size = std::min(together, count - first);
      nearestShapes(model, tails, normals.middleCols(first, size),
                    distances.middleCols(first, size));
    });
    for (int sample = 0; sample < count; ++sample)
      specificity.add(perLandmark * distances.col(sample));
    report(progress, static_cast<double>(begin + count) / parameters.samples);
  }
  measures.specificity = specificity.mean();
  measures.specificityError = specificity.error();
}

}  // namespace

ModelMeasures measureModel(const ShapeModel& model, Eigen::Index modes,
                           const ModelMeasureParameters& parameters, const Progress& progress) {
  requireRange("number of samples for the specificity", parameters.samples,
               Range::between(1, ModelMeasureParameters::maxSamples));
  requireRange("number of threads", parameters.threads, Range::atLeast(0));
  requireRange("number of modes", static_cast<double>(modes), Range::atLeast(0));
  modes = std::min(modes, model.modeCount());
  const double perLandmark = 1 / std::sqrt(static_cast<double>(model.mean.rows()));

  ModelMeasures measures;
  measures.compactness.resize(modes);
  double sum = 0;
  for (Eigen::Index m = 0; m < modes; ++m) measures.compactness[m] = sum += model.eigenvalues[m];

  if (modes > 0) {
    ThreadPool pool(parameters.threads);
    const Eigen::MatrixXd distances =
        perLandmark * leaveOneOut(model.scores, modes, pool, part(progress, 0, 0.7));
    Statistics generalisation(modes);
    for (Eigen::Index k = 0; k < distances.rows(); ++k)
      generalisation.add(distances.row(k).transpose());
    measures.generalisation = generalisation.mean();
    measures.generalisationError = generalisation.error();
    measureSpecificity(model, modes, parameters, pool, part(progress, 0.7, 1), measures);
  }
  report(progress, 1);
  return measures;
}

}  // namespace sphere_propagation
