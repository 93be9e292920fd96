// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The columns of a motion model, and the products with them that fits spend their time in.
///
/// All that is done in single precision or by kernels made by hand is done here and in
/// dense_kernels.h, behind functions whose names say "rough": what each of them saves is measured
/// in docs/propagation_robust.md.

#include <Eigen/Core>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/propagation/motion/dense_kernels.h"

namespace sphere_propagation {

/// B of motion_model.h: 3 rows per node, local columns first, then those of translation, strain and
/// rotation.
class MotionBasis {
 public:
  static constexpr int pivots = 80;  ///< nodes that the kernel is factored from
  static constexpr int localColumns = 3 * pivots;
  static constexpr int translationColumns = 3, strainColumns = 6, rotationColumns = 3;
  static constexpr int affineColumns = translationColumns + strainColumns + rotationColumns;
  static constexpr int columns = localColumns + affineColumns;

  /// nodes: X, #N by 3; areas: #N, by which the pivots are chosen; radius: R.
  MotionBasis(const Points& nodes, const Eigen::VectorXd& areas, double radius);

  /// B c: #N by 3.
  Points displacements(const Eigen::VectorXd& c) const;
  /// B_i^T m: what a coefficient moves node i along the direction m. Length `columns`.
  void project(int i, const Vector3& m, double* row) const;
  /// The sum of B_i^T f_i. forces: f, #N by 3. Length `columns`.
  Eigen::VectorXd projectAll(const Points& forces) const;

  /// Fields y x S y of the arms y, S symmetric without trace: one end turns against the other. A
  /// round surface shows them as little as it shows a rotation. Local coefficients, a column for
  /// each of five orthonormal S.
  Eigen::MatrixXd twists() const;

  /// As above, the local columns in single precision: 1e-7 of the largest entry, which the noise of
  /// any data exceeds by far.
  Points roughDisplacements(const Eigen::VectorXd& c) const;
  Eigen::VectorXd roughProjectAll(const Points& forces) const;
  /// sqrt(w_i) B_i^T m_i, one row a node: #N by `columns`. directions, weights: as below.
  RowsF roughRows(const Points& directions, const Eigen::VectorXd& weights) const;
  /// The sum of w_i (B_i^T m_i) (B_i^T m_i)^T, in single precision: `columns` by `columns`.
  /// directions: m, #N by 3; weights: w, #N, none negative.
  Eigen::MatrixXd roughInformation(const Points& directions, const Eigen::VectorXd& weights) const;

 private:
  void projectAffine(Eigen::Index i, const Vector3& m, double* row) const;
  Points withAffine(const Eigen::VectorXd& local, const Eigen::VectorXd& c) const;
  Eigen::VectorXd withAffine(const Eigen::VectorXd& local, const Points& forces) const;

  // 3 #N rows: x y z of each node.
  Eigen::Matrix<double, Eigen::Dynamic, localColumns, Eigen::RowMajor> local_;
  RowsF single_;  // the same, rounded
  Points arms_;   // (X - centre) / R, #N by 3
};

}  // namespace sphere_propagation
