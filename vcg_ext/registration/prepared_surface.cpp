// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/registration/prepared_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "vcg_ext/base/lazy.h"
#include "vcg_ext/base/linear_solvers.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

constexpr int sampleCount = 100;

/// Vertices each as far as possible from those before; the first is the one farthest from the
/// centre.
std::vector<int> spreadOver(const Points& points, const Vector3& centre) {
  const auto count = std::min<Eigen::Index>(sampleCount, points.rows());
  std::vector<int> spread;
  Eigen::Index next = 0;
  (points.rowwise() - centre.transpose()).rowwise().squaredNorm().maxCoeff(&next);
  Eigen::VectorXd distance =
      Eigen::VectorXd::Constant(points.rows(), std::numeric_limits<double>::infinity());
  for (Eigen::Index i = 0; i < count; ++i) {
    spread.push_back(static_cast<int>(next));
    const Eigen::RowVector3d chosen = points.row(next);
    for (Eigen::Index j = 0; j < points.rows(); ++j)
      distance[j] = std::min(distance[j], (points.row(j) - chosen).squaredNorm());
    distance.maxCoeff(&next);
  }
  return spread;
}

Points rowsOf(const Points& points, const std::vector<int>& rows) {
  Points some(static_cast<Eigen::Index>(rows.size()), 3);
  for (size_t i = 0; i < rows.size(); ++i)
    some.row(static_cast<Eigen::Index>(i)) = points.row(rows[i]);
  return some;
}

Eigen::Matrix3d axesOf(const Points& points, const Vector3& centre, const Eigen::VectorXd& shares) {
  const Points centred = points.rowwise() - centre.transpose();
  const Eigen::Matrix3d covariance = centred.transpose() * shares.asDiagonal() * centred;
  const SymmetricEigen eigen = eigenOf(covariance);  // ascending
  Eigen::Matrix3d axes;
  axes.col(0) = eigen.vectors.col(2);
  axes.col(1) = eigen.vectors.col(1);
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

}  // namespace

struct PreparedSurface::Data {
  explicit Data(ClosedSurface whole)
      : surface(std::move(whole)),
        areas(vertexAreas(surface.vertices(), surface.faces())),
        area(areas.sum()),
        radius(radiusOfSphere(area)),
        volume(enclosedVolume(surface.vertices(), surface.faces())),
        meanEdge(meanEdgeLength(surface.vertices(), surface.faces())),
        centre(surface.vertices().transpose() * areas / area) {}

  ClosedSurface surface;
  Eigen::VectorXd areas;  // of the vertices
  double area, radius, volume, meanEdge;
  Vector3 centre;
  Lazy<Points> normals, samples, sampleNormals;
  Lazy<std::vector<int>> sampleVertices;
  Lazy<Eigen::Matrix3d> axes;
  Lazy<VertexLocator> vertexLocator;
  Lazy<SurfaceLocator> locator;
};

PreparedSurface::PreparedSurface(ClosedSurface surface)
    : data_(std::make_shared<const Data>(std::move(surface))) {}

const ClosedSurface& PreparedSurface::surface() const { return data_->surface; }
double PreparedSurface::area() const { return data_->area; }
double PreparedSurface::radius() const { return data_->radius; }
double PreparedSurface::volume() const { return data_->volume; }
double PreparedSurface::meanEdge() const { return data_->meanEdge; }
const Vector3& PreparedSurface::centre() const { return data_->centre; }

const Points& PreparedSurface::normals() const {
  return data_->normals.get(
      [this] { return vertexNormals(surface().vertices(), surface().faces()); });
}

const Eigen::Matrix3d& PreparedSurface::axes() const {
  return data_->axes.get(
      [this] { return axesOf(surface().vertices(), centre(), data_->areas / data_->area); });
}

const Points& PreparedSurface::samples() const {
  return data_->samples.get([this] { return rowsOf(surface().vertices(), sampleVertices()); });
}

const Points& PreparedSurface::sampleNormals() const {
  return data_->sampleNormals.get([this] { return rowsOf(normals(), sampleVertices()); });
}

const std::vector<int>& PreparedSurface::sampleVertices() const {
  return data_->sampleVertices.get([this] { return spreadOver(surface().vertices(), centre()); });
}

const VertexLocator& PreparedSurface::vertexLocator() const {
  return data_->vertexLocator.get([this] { return VertexLocator(surface().vertices()); });
}

const SurfaceLocator& PreparedSurface::locator() const {
  return data_->locator.get(
      [this] { return SurfaceLocator(surface().vertices(), surface().faces()); });
}

void PreparedSurface::prepare() const {
  normals();
  axes();
  samples();
  sampleNormals();
  vertexLocator();
  locator();
}

}  // namespace sphere_propagation
