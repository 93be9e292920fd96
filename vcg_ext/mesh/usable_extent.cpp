// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/usable_extent.h"

#include <algorithm>
#include <cmath>

#include "vcg_ext/base/linear_solvers.h"

namespace sphere_propagation {
void requireUsableExtent(const ClosedSurface& surface) {
  requireUsableExtent(surface.vertices(), surface.name());
}

void requireUsableExtent(const Points& vertices, const std::string& name) {
  const auto fail = [&](Fault fault, double value = 0) {
    throw SurfaceError(
        Finding(fault, name).of(vertices.rows(), 0).at(value, minExtent, maxCoordinate));
  };
  const Eigen::RowVector3d low = vertices.colwise().minCoeff(),
                           high = vertices.colwise().maxCoeff();
  const double coordinate = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
  if (coordinate > maxCoordinate) fail(Fault::CoordinateTooLarge, coordinate);
  const double extent = (high - low).maxCoeff();
  if (extent < minExtent) fail(Fault::ExtentTooSmall, extent);
  const Points centred = (vertices.rowwise() - 0.5 * (low + high)) / extent;
  const Eigen::RowVector3d mean = centred.colwise().mean();
  const Eigen::Matrix3d scatter =
      (centred.transpose() * centred) / static_cast<double>(vertices.rows()) -
      mean.transpose() * mean;
  const Vector3 squares = eigenOf(scatter).values;
  if (squares[0] < minThickness * minThickness * squares[2]) fail(Fault::Flat);
}

}  // namespace sphere_propagation
