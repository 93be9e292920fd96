// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/usable_extent.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "vcg_ext/base/text.h"

namespace sphere_propagation {
namespace {

using Defect = SurfaceError::Defect;

[[noreturn]] void fail(const ClosedSurface& surface, Defect defect, const std::string& text) {
  throw SurfaceError(defect, surface.vertexCount(), 0, "Layer \"" + surface.name() + "\": " + text);
}

}  // namespace

void requireUsableExtent(const ClosedSurface& surface) {
  const Points& vertices = surface.vertices();
  const Eigen::RowVector3d low = vertices.colwise().minCoeff(),
                           high = vertices.colwise().maxCoeff();
  const double coordinate = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
  if (coordinate > maxCoordinate)
    fail(surface, Defect::CoordinateRange,
         "its coordinates reach " + shortNumber(coordinate) + ", and beyond " +
             shortNumber(maxCoordinate) +
             " nothing can be computed. Bring all layers to a unit such as mm (\"Transform: Scale, "
             "Normalize\").");
  const double extent = (high - low).maxCoeff();
  if (extent < minExtent)
    fail(surface, Defect::CoordinateRange,
         "it is " + shortNumber(extent) + " large, and below " + shortNumber(minExtent) +
             " nothing can be computed. Bring all layers to a unit such as mm (\"Transform: Scale, "
             "Normalize\").");
  const Points centred = (vertices.rowwise() - 0.5 * (low + high)) / extent;
  const Eigen::RowVector3d mean = centred.colwise().mean();
  const Eigen::Matrix3d scatter =
      (centred.transpose() * centred) / static_cast<double>(vertices.rows()) -
      mean.transpose() * mean;
  const Vector3 squares =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter, Eigen::EigenvaluesOnly).eigenvalues();
  if (squares[0] < minThickness * minThickness * squares[2])
    fail(surface, Defect::Flat,
         "it is flat: all its vertices lie in one plane. If its matrix flattens it, undo that "
         "(\"Matrix: Reset Current Matrix\"); else load the mesh again.");
}

}  // namespace sphere_propagation
