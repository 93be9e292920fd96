// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/label_grid.h"

#include <Eigen/LU>
#include <cmath>
#include <sstream>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {

double LabelGrid::voxelVolume() const {
  return std::fabs(toWorld.topLeftCorner<3, 3>().determinant());
}

void LabelGrid::check() const {
  const auto inWords = [](const auto& row) {
    std::ostringstream text;
    text << row;
    return text.str();
  };
  if (size.minCoeff() < 1)
    throw VolumeError(
        Finding(Fault::EmptyVolume)
            .saying(inWords(size[0]) + " x " + inWords(size[1]) + " x " + inWords(size[2])));
  if (values.size() != voxelCount())
    throw VolumeError(Finding(Fault::LabelCount)
                          .of(static_cast<long>(values.size()))
                          .amid(static_cast<long>(voxelCount())));
  if (!toWorld.allFinite()) throw VolumeError(Finding(Fault::PlaceNotFinite));
  if (toWorld.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    throw VolumeError(Finding(Fault::MatrixNotAffine).saying(inWords(toWorld.row(3))));
  // Relative to the product of the spacings: 1 for right angles, 0 in a plane.
  const double product = spacing().prod(), volume = voxelVolume();
  if (!(product > 0 && std::isfinite(product) && volume > 1e-3 * product))
    throw VolumeError(
        Finding(Fault::MatrixFlattens).saying(inWords(spacing().transpose())).at(volume));
}

std::map<std::int32_t, long> LabelGrid::count() const {
  std::map<std::int32_t, long> counts;
  for (size_t i = 0; i < values.size();) {  // labels come in runs
    size_t end = i + 1;
    while (end < values.size() && values[end] == values[i]) ++end;
    if (values[i] != 0) counts[values[i]] += static_cast<long>(end - i);
    i = end;
  }
  return counts;
}

}  // namespace sphere_propagation
