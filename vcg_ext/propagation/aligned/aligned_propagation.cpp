// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/aligned/aligned_propagation.h"

#include <Eigen/Cholesky>

#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/registration/rigid_alignment.h"

namespace sphere_propagation {
namespace {

constexpr int icpIterations = 30;
constexpr int affineIterations = 10;
/// Weight of staying as it is against a unit of the surface's area: enough that noise cannot shear
/// a shape without features, a tenth of what the data say of a strain.
constexpr double ridge = 0.03;

/// A third of the area of the faces around each vertex, as a share of all.
Eigen::VectorXd vertexShares(const Points& vertices, const Triangles& faces) {
  const Eigen::VectorXd areas = vertexAreas(vertices, faces);
  return areas / areas.sum();
}

/// Where each point is drawn to: the closest point of a surface that looks the same way.
Points closestPoints(const ClosedSurface& surface, const SurfaceLocator& locator,
                     const Points& points, const Points& normals) {
  Points closest(points.rows(), 3);
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    const Vector3 x = points.row(v).transpose();
    SurfacePoint point = locator.closest(x, normals.row(v).transpose(), minNormalAgreement);
    if (point.face < 0) point = locator.closest(x);
    closest.row(v) = point.interpolate(surface.faces(), surface.vertices()).transpose();
  }
  return closest;
}

/// Closest points again, with an affine map x -> A x + b: each iteration minimises
///   sum of shares |A x + b - y|^2 + ridge r^2 |A - 1|^2,   r the radius of a sphere of the same
///   area.
Points alignAffinely(const Points& points, const Triangles& faces, const ClosedSurface& target) {
  const SurfaceLocator locator(target.vertices(), target.faces());
  const Eigen::VectorXd shares = vertexShares(points, faces);
  const Eigen::RowVector3d centre = shares.transpose() * points;
  const Points centred = points.rowwise() - centre;
  const Eigen::Matrix3d prior =
      ridge * faceAreas(points, faces).sum() / (4 * pi) * Eigen::Matrix3d::Identity();
  const Eigen::LDLT<Eigen::Matrix3d> normal(centred.transpose() * shares.asDiagonal() * centred +
                                            prior);
  Points moved = points;
  for (int i = 0; i < affineIterations; ++i) {
    const Points to = closestPoints(target, locator, moved, vertexNormals(moved, faces));
    const Eigen::RowVector3d shift = shares.transpose() * to;
    const Eigen::Matrix3d transposed =
        normal.solve(centred.transpose() * shares.asDiagonal() * to + prior);
    moved = (centred * transposed).rowwise() + shift;
  }
  return moved;
}

/// The reference's vertices where it lies on the target: centroids together, then closest points,
/// rigidly, affinely.
Points alignedVertices(const ClosedSurface& reference, const ClosedSurface& target) {
  Points points = reference.vertices();
  points.rowwise() += (target.vertices().colwise().mean() - points.colwise().mean()).eval();
  points =
      alignRigidly(points, VertexLocator(target.vertices()), icpIterations).motion.applyTo(points);
  return alignAffinely(points, reference.faces(), target);
}

}  // namespace

TransferredMap propagateAligned(const MappedSurface& reference, const ClosedSurface& target) {
  return transferMap(reference, alignedVertices(reference.surface(), target), target);
}

}  // namespace sphere_propagation
