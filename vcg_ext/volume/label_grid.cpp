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
  std::ostringstream text;
  if (size.minCoeff() < 1) {
    text << "The label volume has no voxels: its size is " << size[0] << " x " << size[1] << " x "
         << size[2] << ".";
  } else if (values.size() != voxelCount()) {
    text << "The label volume has " << values.size() << " labels for " << voxelCount()
         << " voxels.";
  } else if (!toWorld.allFinite()) {
    text << "The label volume's position in space is not finite: its affine matrix holds NaN or "
            "infinite numbers.";
  } else if (toWorld.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    text << "The label volume's matrix is not affine: its last row is " << toWorld.row(3) << ".";
  } else {
    // Relative to the product of the spacings: 1 for right angles, 0 in a plane.
    const double product = spacing().prod(), volume = voxelVolume();
    if (product > 0 && std::isfinite(product) && volume > 1e-3 * product) return;
    text << "The label volume's affine matrix maps the voxels into a plane: the spacings are "
         << spacing().transpose() << " mm and a voxel's volume is " << volume << " mm^3.";
  }
  throw VolumeError(text.str());
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
