// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A low-rank model of how a surface moves: a Gaussian process on a template of it.
///
///   x_i(c) = X_i + B_i c,   i over the nodes of the template, c the coefficients
///
/// The template is the icosphere through the surface's map. B (motion_basis.h) has local columns, a
/// factor of a kernel of vector fields, and twelve affine ones: translation, strain, rotation. The
/// kernel is a sum of three, for r = X_i - X_j, with lengths l in R, the radius of the sphere of
/// the template's area (the model has no unit):
///
///   share   kernel, times exp(-|r|^2 / 2 l^2)          l
///   0.5     1                                          0.35   any smooth field
///   0.225   1 - r r^T / l^2                            0.5    fields without curl
///   0.275   (r r^T / l^2 + (2 - |r|^2 / l^2) 1) / 2    0.4    fields without divergence
///
/// Tissue that contracts hardly turns in itself and hardly changes its volume, which a kernel that
/// treats coordinates one by one does not know; but these two alone leave too little to motion of
/// long wavelength. The kernel measures straight through space, so both sides of a thin wall move
/// together.
///
/// M. Luethi, T. Gerig, C. Jud, T. Vetter, Gaussian process morphable models, 2018; the kernels:
/// F. J. Narcowich, J. D. Ward, Generalized Hermite interpolation via matrix-valued conditionally
/// positive definite functions, 1994; for shapes: M. Micheli, J. A. Glaunes, Matrix-valued kernels
/// for shape deformation analysis, 2014; the columns by pivoted Cholesky decomposition:
/// H. Harbrecht, M. Peters, R. Schneider, On the low-rank approximation by the pivoted Cholesky
/// decomposition, 2012.

#include <Eigen/Core>
#include <vector>

#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/propagation/motion/motion_basis.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

class MotionModel {
 public:
  /// root: the surface that moves, with its map.
  explicit MotionModel(const MappedSurface& root);

  const Points& nodes() const { return template_.vertices; }  ///< X, #N by 3
  const Triangles& faces() const { return template_.faces; }  ///< of the template
  /// #N, a third of the area of the faces round each node.
  const Eigen::VectorXd& areas() const { return areas_; }
  /// A0, the unit of motion: the surface's area over its vertices, or over 5000 where it has fewer.
  double meanVertexArea() const { return meanVertexArea_; }
  const MotionBasis& basis() const { return basis_; }

  /// The nodes moved by coefficients c: #N by 3.
  Points movedNodes(const Eigen::VectorXd& c) const { return nodes() + basis_.displacements(c); }
  /// The same in single precision.
  Points roughMovedNodes(const Eigen::VectorXd& c) const {
    return nodes() + basis_.roughDisplacements(c);
  }
  /// Where directions from the centre of the sphere, of any length but zero, lie in the template.
  std::vector<SurfacePoint> sitesOf(const std::vector<Vector3>& directions) const;
  /// The vertices of the surface itself, moved with the template (interpolated in the face of the
  /// icosphere that their map lies in): #V by 3.
  Points movedVertices(const Eigen::VectorXd& c) const;

 private:
  Icosphere template_;  // with X as its vertices
  Eigen::VectorXd areas_;
  double meanVertexArea_;
  MotionBasis basis_;
  Points vertices_;                 // of the surface
  std::vector<SurfacePoint> site_;  // where each vertex lies in the template
};

}  // namespace sphere_propagation
