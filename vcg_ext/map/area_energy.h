#pragma once
/// The energy whose minimum is the area-preserving map: log area ratio plus a shape term.
///
///   E = sum_f w_f ( A ln^2(s_f / a_f) + B q_f ),      w_f = sqrt(a_f mean a)
///
/// s_f: solid angle of face f on the sphere; a_f: its target, the face's area on the mesh scaled to the sphere's 4 pi.
/// q_f = D_f / (2 s_f), D_f the Dirichlet energy of the map of face f with the cotangents of the mesh's triangle: the
/// quotient that is 1 for a conformal map and larger otherwise (K. Hormann and G. Greiner, MIPS, 2000). It tends to
/// infinity where a face degenerates, which keeps faces in shape while areas travel.
/// The logarithm counts a face twice too large as much as one half as large (J. Schmidt et al. use it likewise,
/// Surface maps via adaptive triangulations, 2023). The square root in w_f keeps small faces from being sacrificed.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// What the energy knows of one face.
struct FaceTarget {
  double area = 0;                    ///< a_f, steradian
  double weight = 0;                  ///< w_f
  std::array<double, 3> stiffness{};  ///< D_f = 1/2 sum_k stiffness[k] |edge opposite corner k|^2
};

/// Weights of the two terms.
struct AreaEnergyWeights {
  double area = 1;   ///< A
  double shape = 0;  ///< B
};

/// A tangent vector in the frame of its vertex, and a 2 x 2 block.
using Tangent = Eigen::Vector2d;
using TangentBlock = Eigen::Matrix2d;

/// The energy of one face to second order, in the tangent frames of its corners.
struct FaceExpansion {
  double solidAngle = 0;
  double energy = 0;
  std::array<Tangent, 3> gradient;
  /// hessian[i][j], positive semidefinite as a whole: Gauss-Newton for the logarithm; exact up to the curvature of s_f
  /// for the quotient, which is jointly convex in D_f and s_f.
  std::array<std::array<TangentBlock, 3>, 3> hessian;
};

/// Targets of all faces of a mesh. vertices: #V by 3; faces: #F by 3; the total area must be positive. Faces smaller
/// than 1e-5 of the mean count as that large, so that a face without area keeps a place on the sphere.
std::vector<FaceTarget> faceTargets(const Points& vertices, const Triangles& faces);

/// Energy of a face with its corners at unit vectors p, between which it has the solid angle s; infinity unless s > 0.
double faceEnergy(const FaceTarget& target, const AreaEnergyWeights& weights, double s,
                  const std::array<Vector3, 3>& p);

/// The same with first and second derivatives. frame[k]: the two tangents at corner k.
FaceExpansion expandFaceEnergy(const FaceTarget& target, const AreaEnergyWeights& weights,
                               const std::array<Vector3, 3>& p, const std::array<std::array<Vector3, 2>, 3>& frame);

}  // namespace sphere_propagation
