// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A low-rank model of how a surface moves: a Gaussian process on a template of it.
///
///   x_i(c) = X_i + B_i c,   i over the nodes of the template, c the coefficients
///
/// The template is the icosphere through the surface's map. B has local columns, a factor of a
/// kernel of vector fields, and twelve affine ones: translation, strain, rotation. The kernel is a
/// sum of three, for r = X_i - X_j:
///   0.5    exp(-|r|^2 / 2 l^2)                                             l = 0.35 R: any smooth
///   field 0.225  (1 - r r^T / l^2) exp(-|r|^2 / 2 l^2)                           l = 0.5 R: fields
///   without curl 0.275  (r r^T / l^2 + (2 - |r|^2 / l^2) 1) / 2  exp(-|r|^2 / 2 l^2)    l = 0.4 R:
///   fields without divergence
/// Tissue that contracts hardly turns in itself and hardly changes its volume, which a kernel that
/// treats coordinates one by one does not know; but these two alone leave too little to motion of
/// long wavelength. The kernel measures straight through space, so both sides of a thin wall move
/// together. All lengths are relative to R, the radius of the sphere of the template's area: the
/// model has no unit.
///
/// M. Luethi, T. Gerig, C. Jud, T. Vetter, Gaussian process morphable models, 2018; the kernels: F.
/// J. Narcowich, J. D. Ward, Generalized Hermite interpolation via matrix-valued conditionally
/// positive definite functions, 1994; for shapes: M. Micheli, J. A. Glaunes, Matrix-valued kernels
/// for shape deformation analysis, 2014; the columns by pivoted Cholesky decomposition: H.
/// Harbrecht, M. Peters, R. Schneider, On the low-rank approximation by the pivoted Cholesky
/// decomposition, 2012.

#include <Eigen/Core>
#include <vector>

#include "vcg_ext/base/dense_kernels.h"
#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

class MotionModel {
 public:
  static constexpr int pivots = 80;  ///< nodes that the kernel is factored from
  static constexpr int localColumns = 3 * pivots;
  /// Columns of translation, strain and rotation, in this order behind the local ones.
  static constexpr int translationColumns = 3, strainColumns = 6, rotationColumns = 3;
  static constexpr int affineColumns = translationColumns + strainColumns + rotationColumns;
  static constexpr int columns = localColumns + affineColumns;

  /// root: the surface that moves, with its map.
  explicit MotionModel(const MappedSurface& root);

  const Points& nodes() const { return nodes_; }     ///< X, #N by 3
  const Triangles& faces() const { return faces_; }  ///< of the template
  const Eigen::VectorXd& areas() const {
    return areas_;
  }  ///< #N, a third of the area of the faces round each node
  /// A0, the unit of motion: the surface's area over its vertices, or over 5000 where it has fewer.
  double meanVertexArea() const { return meanVertexArea_; }

  /// Of the sums over local columns. Fits go through their factor, which is larger than what
  /// processors keep close by, at every iteration: in single precision, which the noise of any data
  /// exceeds by far, they take a third of the time.
  enum class Precision { Double, Single };

  /// The nodes moved by coefficients c: #N by 3.
  Points movedNodes(const Eigen::VectorXd& c, Precision precision = Precision::Double) const;
  /// The vertices of the surface itself, moved with the template (interpolated in the face of the
  /// icosphere that their map lies in): #V by 3.
  Points movedVertices(const Eigen::VectorXd& c) const;
  /// B_i^T m: what a coefficient moves node i along the direction m. Length `columns`.
  void project(int i, const Vector3& m, double* row) const;
  /// s_i B_i^T m_i of all nodes, in single precision: #N by `columns`. directions: m, #N by 3;
  /// scales: s, #N.
  RowsF projectEach(const Points& directions, const Eigen::VectorXd& scales) const;
  /// The sum of B_i^T f_i. forces: f, #N by 3. Length `columns`.
  Eigen::VectorXd projectAll(const Points& forces, Precision precision = Precision::Double) const;

 private:
  Points displacements(const Eigen::VectorXd& c, Precision precision) const;
  void projectAffine(int i, const Vector3& m, double* row) const;

  Points nodes_;
  Triangles faces_;
  Eigen::VectorXd areas_;
  double meanVertexArea_ = 0;
  Eigen::Matrix<double, Eigen::Dynamic, localColumns, Eigen::RowMajor>
      local_;                       // 3 #N by 240, x y z of each node
  RowsF single_;                    // the same, rounded
  Points arms_;                     // (X - centre) / R, #N by 3
  Points vertices_;                 // of the surface
  std::vector<SurfacePoint> site_;  // where each vertex lies in the template
};

}  // namespace sphere_propagation
