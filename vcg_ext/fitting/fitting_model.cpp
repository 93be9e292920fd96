// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/fitting/fitting_model.h"

#include <algorithm>
#include <cmath>

#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/model/leave_one_out.h"

namespace sphere_propagation {
namespace {

constexpr double kernelLength = 0.35;  // in radii

/// Factor of the kernel over these nodes, by pivots of the most area that is left to explain.
Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> kernelColumns(
    const Points& nodes, const Eigen::VectorXd& areas, double length) {
  const auto count = std::min<Eigen::Index>(FittingModel::pivots, nodes.rows());
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(nodes.rows(), count);
  Eigen::ArrayXd rest = Eigen::ArrayXd::Ones(nodes.rows());
  for (Eigen::Index k = 0; k < count; ++k) {
    Eigen::Index pivot = 0;
    if (!((rest * areas.array()).maxCoeff(&pivot) > 0)) return columns.leftCols(k);
    const Eigen::ArrayXd squares = (nodes.rowwise() - nodes.row(pivot)).rowwise().squaredNorm();
    const Eigen::VectorXd kernel = (-squares / (2 * length * length)).exp();
    columns.col(k) = (kernel - columns.leftCols(k) * columns.row(pivot).head(k).transpose()) /
                     std::sqrt(rest[pivot]);
    rest = (rest - columns.col(k).array().square()).max(0.0);
    rest[pivot] = 0;
  }
  return columns;
}

}  // namespace

std::optional<double> learntLocalDeviation(const ShapeModel& model, Eigen::Index modes,
                                           ThreadPool& pool) {
  if (model.scores.rows() < minShapesToLearnFrom) return std::nullopt;
  modes = std::min(modes, model.scores.cols());
  const Eigen::VectorXd left =
      modes > 0 ? Eigen::VectorXd(leaveOneOut(model.scores, modes, pool).col(modes - 1))
                : Eigen::VectorXd(model.scores.rowwise().norm());
  return std::sqrt(left.squaredNorm() / static_cast<double>(left.size() * model.mean.size()));
}

double assumedLocalDeviation(const ShapeModel& model) {
  if (model.noiseVariance > 0) return std::sqrt(model.noiseVariance);
  constexpr double missing = 0.05;
  return std::sqrt(missing * model.eigenvalues.sum() / static_cast<double>(model.mean.size()));
}

bool isWithoutSize(const ShapeModel& model) {
  const Eigen::Index shapes = model.scores.rows();
  if (shapes < 2 || model.modeCount() == 0) return false;
  const Points mean = model.mean.rowwise() - model.mean.colwise().mean();
  Eigen::VectorXd ratios(shapes);
  for (Eigen::Index k = 0; k < shapes; ++k) {
    Points shape = model.shape(Eigen::VectorXd(model.scores.row(k).transpose()));
    shape.rowwise() -= shape.colwise().mean().eval();
    ratios[k] = shape.cwiseProduct(mean).sum() / shape.squaredNorm();
  }
  constexpr double same = 1e-3;
  const double average = ratios.mean();
  return (ratios.array() - average).abs().maxCoeff() < same * std::fabs(average);
}

FittingModel::FittingModel(const ShapeModel& model, ThreadPool& pool,
                           const FittingModelParameters& parameters)
    : mean_(model.mean), faces_(model.faces) {
  requireRange("number of modes", static_cast<double>(parameters.modes), Range::atLeast(0));
  const Eigen::VectorXd areas = vertexAreas(mean_, faces_);
  radius_ = radiusOfSphere(areas.sum());
  if (!(radius_ > 0)) throw ParameterError("The mean shape of the model has no area.");
  const Eigen::Index modes = std::min(parameters.modes, model.modes.cols());
  std::optional<double> deviation = parameters.localDeviation;
  if (deviation) requireRange("local deviation", *deviation, Range::atLeast(0));
  if (!deviation) deviation = learntLocalDeviation(model, modes, pool);
  localDeviation_ = deviation.value_or(assumedLocalDeviation(model));
  constexpr double nothing = 1e-9;  // what rounding leaves of shapes that are one and the same
  if (localDeviation_ < nothing * radius_) localDeviation_ = 0;
  modes_ = model.modes.leftCols(modes);
  local_.resize(mean_.rows(), 0);
  if (localDeviation_ > 0) local_ = kernelColumns(mean_, areas, kernelLength * radius_);
  variances_.resize(modes + 3 * local_.cols());
  // A mode that the file gives no variance is held, not divided by.
  variances_.head(modes) = model.eigenvalues.head(modes).cwiseMax(1e-12 * radius_ * radius_);
  variances_.tail(3 * local_.cols()).setConstant(localDeviation_ * localDeviation_);
}

Points FittingModel::shape(const Eigen::VectorXd& c) const {
  const Eigen::Index modes = std::min(c.size(), modeCount());
  Points moved = mean_;
  Eigen::Map<Eigen::VectorXd>(moved.data(), moved.size()) += modes_.leftCols(modes) * c.head(modes);
  if (c.size() > modes) {
    const Eigen::Map<const Points> local(c.data() + modes, local_.cols(), 3);
    moved += local_ * local;
  }
  return moved;
}

void FittingModel::project(Eigen::Index landmark, const Vector3& n, double weight,
                           Eigen::Ref<Eigen::RowVectorXd> row) const {
  const Eigen::Index modes = std::min(row.size(), modeCount());
  row.head(modes) += (weight * n.transpose()) * modes_.block(3 * landmark, 0, 3, modes);
  if (row.size() == modes) return;
  for (Eigen::Index k = 0; k < local_.cols(); ++k)
    row.segment(modes + 3 * k, 3) += weight * local_(landmark, k) * n.transpose();
}

}  // namespace sphere_propagation
