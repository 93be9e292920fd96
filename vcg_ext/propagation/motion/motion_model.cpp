// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_model.h"

#include <algorithm>

#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/sphere/sphere_locator.h"

namespace sphere_propagation {
namespace {

constexpr int frequency = 10;  // of the template's icosphere: 1002 nodes
// The unit of motion is that of a surface of at least so many vertices: a coarser one does not move
// more.
constexpr int minVertices = 5000;

/// The icosphere through the root's map.
Icosphere templateOf(const MappedSurface& root) {
  Icosphere sphere = icosphere(frequency);
  const SphereLocator under(root);
  for (Eigen::Index i = 0; i < sphere.vertices.rows(); ++i)
    sphere.vertices.row(i) = under.locate(sphere.vertices.row(i).transpose())
                                 .interpolate(root.faces(), root.surface().vertices())
                                 .transpose();
  return sphere;
}

/// Where directions lie in the template.
std::vector<SurfacePoint> sitesUnder(const std::vector<Vector3>& directions) {
  const Icosphere sphere = icosphere(frequency);
  const SphereLocator under(
      MappedSurface(ClosedSurface(sphere.vertices, sphere.faces, "icosphere"), sphere.vertices));
  std::vector<SurfacePoint> sites;
  sites.reserve(directions.size());
  for (const Vector3& direction : directions) sites.push_back(under.locate(direction));
  return sites;
}

/// Where each vertex lies there.
std::vector<SurfacePoint> sitesOfVertices(const MappedSurface& root) {
  std::vector<Vector3> directions;
  directions.reserve(static_cast<size_t>(root.vertexCount()));
  for (int v = 0; v < root.vertexCount(); ++v) directions.push_back(root.position(v));
  return sitesUnder(directions);
}

double meanVertexAreaOf(const ClosedSurface& surface) {
  return faceAreas(surface.vertices(), surface.faces()).sum() /
         std::max(surface.vertexCount(), minVertices);
}

}  // namespace

MotionModel::MotionModel(const MappedSurface& root)
    : template_(templateOf(root)),
      areas_(vertexAreas(template_.vertices, template_.faces)),
      meanVertexArea_(meanVertexAreaOf(root.surface())),
      basis_(template_.vertices, areas_, radiusOfSphere(areas_.sum())),
      vertices_(root.surface().vertices()),
      site_(sitesOfVertices(root)) {}

std::vector<SurfacePoint> MotionModel::sitesOf(const std::vector<Vector3>& directions) const {
  return sitesUnder(directions);
}

Points MotionModel::movedVertices(const Eigen::VectorXd& c) const {
  const Points moved = basis_.displacements(c);
  Points vertices = vertices_;
  for (Eigen::Index v = 0; v < vertices.rows(); ++v)
    vertices.row(v) += site_[static_cast<size_t>(v)].interpolate(faces(), moved).transpose();
  return vertices;
}

}  // namespace sphere_propagation
