// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/groupwise/description_length.h"

#include <algorithm>
#include <cmath>

#include "vcg_ext/base/eigen_system.h"

namespace sphere_propagation {

DescriptionLength descriptionLengthOf(const PopulationPose& pose, double cut) {
  const auto count = static_cast<Eigen::Index>(pose.shapes.size());
  Eigen::MatrixXd rows(count, pose.mean.size());
  for (Eigen::Index k = 0; k < count; ++k) {
    const Points weighted =
        pose.weights.cwiseSqrt().asDiagonal() * (pose.shapes[static_cast<size_t>(k)] - pose.mean);
    rows.row(k) = Eigen::Map<const Eigen::RowVectorXd>(weighted.data(), weighted.size());
  }
  const Eigen::MatrixXd gram = rows * rows.transpose() / static_cast<double>(count);
  const EigenSystem modes = eigenSystemOf(gram);
  DescriptionLength length;
  for (const double value : modes.values)
    length.cost += value > cut ? 1 + std::log(value / cut) : std::max(value, 0.0) / cut;
  const Eigen::VectorXd slopes = modes.values.cwiseMax(cut).cwiseInverse();
  length.pull = modes.vectors * slopes.asDiagonal() * modes.vectors.transpose();
  // The mean moves along.
  length.pull.rowwise() -= Eigen::RowVectorXd(length.pull.colwise().mean());
  length.pull.colwise() -= Eigen::VectorXd(length.pull.rowwise().mean());
  return length;
}

}  // namespace sphere_propagation
