// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// How deep the phases of a sequence are inside on average, at each place of space.

#include <vector>

#include "vcg_ext/volume/slice_interpolation.h"

namespace sphere_propagation {

/// The mean of the phases' signed distances, by which the handles of all of them are cut and filled
/// at the same places (findHandleRemoval). Distances count up to `reach` working voxels; beyond a
/// phase's grid is outside. Phases lie as they do in space, unless one meets the mean of those
/// before not at all, or by over a quarter more when their centres of mass are brought together, as
/// another patient's; samples of grids that lie a part of a voxel apart are paired with the
/// nearest.
class CommonDepth {
 public:
  static constexpr float reach = 10;

  /// Whether a phase lies on a grid as those before: of the same spacing and axes.
  bool agrees(const InterpolatedLabels& field) const;
  /// Adds a phase that agrees. Returns where its grid lies among the samples.
  Eigen::Vector3i add(const InterpolatedLabels& field);
  int phases() const { return phases_; }
  /// The mean at the samples of a phase's grid, in working voxels.
  std::vector<float> at(const Eigen::Vector3i& place, const Eigen::Vector3i& size) const;

 private:
  float sumAt(const Eigen::Vector3i& sample) const;
  long overlap(const InterpolatedLabels& field, const Eigen::Vector3i& shift) const;
  Eigen::Vector3i placeOf(const InterpolatedLabels& field) const;
  void widen(const Eigen::Vector3i& low, const Eigen::Vector3i& high);

  int phases_ = 0;
  Eigen::Matrix3d axes_ = Eigen::Matrix3d::Identity();  // columns: a sample's step along each axis
  Vector3 origin_ = Vector3::Zero();                    // of the first phase's grid, in the world
  Vector3 centre_ = Vector3::Zero();                    // of the first phase, in its samples
  Eigen::Vector3i low_ = Eigen::Vector3i::Zero();       // where the sums begin
  Grid<float> sums_;                                    // of distances, in samples, plus `reach`
};

}  // namespace sphere_propagation
