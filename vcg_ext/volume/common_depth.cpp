// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/common_depth.h"

#include <Eigen/LU>
#include <algorithm>
#include <utility>

namespace sphere_propagation {
namespace {

constexpr double sameAxes = 1e-4;  // of a step
constexpr double muchMore = 1.25;

Eigen::Matrix3d stepsOf(const InterpolatedLabels& field) {
  return field.toWorld.topLeftCorner<3, 3>() * field.grid.spacing.asDiagonal();
}

/// Of the inside, in samples from the grid's first one.
Vector3 centreOf(const InterpolatedLabels& field) {
  Vector3 sum = Vector3::Zero();
  double count = 0;
  size_t at = 0;
  for (int k = 0; k < field.grid.size[2]; ++k)
    for (int j = 0; j < field.grid.size[1]; ++j)
      for (int i = 0; i < field.grid.size[0]; ++i)
        if (field.grid.values[at++] > 0) {
          sum += Vector3(i, j, k);
          ++count;
        }
  return sum / std::max(count, 1.0);
}

}  // namespace

bool CommonDepth::agrees(const InterpolatedLabels& field) const {
  return phases_ == 0 || (stepsOf(field) - axes_).norm() <= sameAxes * axes_.norm();
}

float CommonDepth::sumAt(const Eigen::Vector3i& sample) const {
  const Eigen::Vector3i x = sample - low_;
  return x.minCoeff() >= 0 && (sums_.size - x).minCoeff() > 0 ? sums_(x[0], x[1], x[2]) : 0;
}

/// How many samples are inside, in the phase and on average.
long CommonDepth::overlap(const InterpolatedLabels& field, const Eigen::Vector3i& shift) const {
  long count = 0;
  size_t at = 0;
  for (int k = 0; k < field.grid.size[2]; ++k)
    for (int j = 0; j < field.grid.size[1]; ++j)
      for (int i = 0; i < field.grid.size[0]; ++i)
        if (field.grid.values[at++] > 0)
          count += sumAt(shift + Eigen::Vector3i(i, j, k)) > reach * static_cast<float>(phases_);
  return count;
}

Eigen::Vector3i CommonDepth::placeOf(const InterpolatedLabels& field) const {
  const Eigen::Matrix3d toSteps = axes_.inverse();
  const Eigen::Vector3i inSpace =
      (toSteps * (field.worldOf(field.grid.origin) - origin_)).array().round().cast<int>();
  const Eigen::Vector3i byCentre = (centre_ - centreOf(field)).array().round().cast<int>();
  const auto meeting = static_cast<double>(overlap(field, inSpace));
  return phases_ > 0 && (meeting == 0 ||
                         static_cast<double>(overlap(field, byCentre)) > muchMore * meeting)
             ? byCentre
             : inSpace;
}

void CommonDepth::widen(const Eigen::Vector3i& low, const Eigen::Vector3i& high) {
  Grid<float> wider(high - low);
  const Eigen::Vector3i from = low_ - low;
  for (int k = 0; k < sums_.size[2]; ++k)
    for (int j = 0; j < sums_.size[1]; ++j)
      std::copy_n(sums_.values.begin() + static_cast<std::ptrdiff_t>(sums_.index(0, j, k)),
                  sums_.size[0],
                  wider.values.begin() +
                      static_cast<std::ptrdiff_t>(wider.index(from[0], j + from[1], k + from[2])));
  low_ = low;
  sums_ = std::move(wider);
}

Eigen::Vector3i CommonDepth::add(const InterpolatedLabels& field) {
  if (phases_ == 0) {
    axes_ = stepsOf(field);
    origin_ = field.worldOf(field.grid.origin);
    centre_ = centreOf(field);
    sums_ = Grid<float>(field.grid.size);
  }
  const Eigen::Vector3i shift = placeOf(field), low = low_.cwiseMin(shift),
                        high = (low_ + sums_.size).cwiseMax(shift + field.grid.size);
  ++phases_;
  if (low != low_ || high != low_ + sums_.size) widen(low, high);
  const Eigen::Vector3i from = shift - low_;
  const auto unit = static_cast<float>(field.grid.spacing[0]);
  size_t at = 0;
  for (int k = 0; k < field.grid.size[2]; ++k)
    for (int j = 0; j < field.grid.size[1]; ++j) {
      float* sum = sums_.values.data() + sums_.index(from[0], j + from[1], k + from[2]);
      for (int i = 0; i < field.grid.size[0]; ++i)
        *sum++ += std::clamp(field.grid.values[at++] / unit, -reach, reach) + reach;
    }
  return shift;
}

std::vector<float> CommonDepth::at(const Eigen::Vector3i& place,
                                   const Eigen::Vector3i& size) const {
  std::vector<float> depth;
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i)
        depth.push_back(sumAt(place + Eigen::Vector3i(i, j, k)) /
                            static_cast<float>(std::max(phases_, 1)) -
                        reach);
  return depth;
}

}  // namespace sphere_propagation
