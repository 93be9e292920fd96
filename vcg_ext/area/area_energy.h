// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The energy whose minimum is the area-preserving map: log area ratio plus a shape term.
///
///   E = sum_f  A w_f ln^2(s_f / a_f) + B a q_f,      w_f = sqrt(a_f a)
///
/// s_f: solid angle of face f on the sphere; a_f: its target, the face's area on the mesh scaled to
/// the sphere's 4 pi; a: the mean of all a_f. q_f = D_f / (2 s_f), D_f the Dirichlet energy of the
/// map of face f with the cotangents of the mesh's triangle: the quotient that is 1 for a conformal
/// map and larger otherwise (K. Hormann and G. Greiner, MIPS, 2000). It tends to infinity where a
/// face degenerates, which keeps faces in shape while areas travel. The logarithm counts a face
/// twice too large as much as one half as large (J. Schmidt et al. use it likewise, Surface maps
/// via adaptive triangulations, 2023). The square root in w_f keeps small faces from being
/// sacrificed; the shape of one face counts as much as that of another, as it does in the mean
/// angle error.

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/sphere/spherical_triangle.h"

namespace sphere_propagation {

/// What the energy knows of one face.
struct FaceTarget {
  double area = 0;                   ///< a_f, steradian
  double weight = 0;                 ///< w_f
  std::array<float, 3> stiffness{};  ///< D_f = 1/2 sum_k stiffness[k] |edge opposite corner k|^2
  float shapeWeight = 0;             ///< a

  FaceTarget() = default;
  /// mean: of the areas of all faces.
  FaceTarget(double area, double mean, const std::array<float, 3>& stiffness)
      : area(area),
        weight(std::sqrt(area * mean)),
        stiffness(stiffness),
        shapeWeight(static_cast<float>(mean)) {}
};

/// Weights of the two terms.
struct AreaEnergyWeights {
  double area = 1;   ///< A
  double shape = 0;  ///< B
};

/// A tangent vector in the frame of its vertex, and a 2 x 2 block.
using Tangent = Eigen::Vector2d;
using TangentBlock = Eigen::Matrix2d;

/// How far the cotangents of the mesh's triangles are trusted: slivers of the mesh need not be
/// slivers on the sphere.
struct ShapeTrust {
  double equilateralShare = 0.02;  ///< blended in: the cotangents of an equilateral triangle
  double minFlatness =
      0.004;  ///< least area of a triangle in its cotangents, relative to its squared edges' sum
};

/// Targets of all faces of a mesh. vertices: #V by 3; faces: #F by 3; the total area must be
/// positive. Faces smaller than minFaceShare of the mean count as that large, so that a face
/// without area keeps a place on the sphere.
std::vector<FaceTarget> faceTargets(const Points& vertices, const Triangles& faces,
                                    const ShapeTrust& trust = {});

/// The stiffness of one triangle with corners p: its cotangents, blended.
std::array<float, 3> faceStiffness(const std::array<Vector3, 3>& p, const ShapeTrust& trust);

/// Dirichlet energy D_f of a face with its corners at p.
inline double dirichletEnergy(const FaceTarget& target, const std::array<Vector3, 3>& p) {
  return 0.5 * (target.stiffness[0] * (p[1] - p[2]).squaredNorm() +
                target.stiffness[1] * (p[2] - p[0]).squaredNorm() +
                target.stiffness[2] * (p[0] - p[1]).squaredNorm());
}

/// Energy of a face with its corners at unit vectors p, between which it has the solid angle s;
/// infinity unless s > 0.
inline double faceEnergy(const FaceTarget& target, const AreaEnergyWeights& weights, double s,
                         const std::array<Vector3, 3>& p) {
  if (!(s > 0)) return std::numeric_limits<double>::infinity();
  const double r = std::log(s / target.area);
  return target.weight * weights.area * r * r + static_cast<double>(target.shapeWeight) *
                                                    weights.shape * dirichletEnergy(target, p) /
                                                    (2 * s);
}

/// The energy of one face to second order, in the tangent frames of its corners, kept in factors.
struct FaceExpansion {
  double solidAngle = 0;
  double energy = 0;
  std::array<Tangent, 3> logArea;   ///< l_k: gradient of ln s_f
  std::array<Tangent, 3> quotient;  ///< d_k: gradient of D_f, divided by 2 s_f
  double slope = 0;                 ///< of the energy in ln s_f
  double curvature = 0;             ///< of the energy in ln s_f
  double shapeWeight = 0;           ///< a B
  std::array<double, 3>
      tie{};  ///< of the edge opposite corner k: what stiffness adds to the blocks

  Tangent gradient(int k) const { return slope * logArea[k] + shapeWeight * quotient[k]; }
  /// Block (k, l). The Hessian is positive semidefinite as a whole: Gauss-Newton for the logarithm;
  /// exact up to the curvature of s_f for the quotient, which is jointly convex in the positions
  /// and s_f. frame[k]: as below.
  TangentBlock hessian(int k, int l, const std::array<std::array<Vector3, 2>, 3>& frame) const {
    TangentBlock block = couple(k, l);
    if (k == l) return block + (tie[(k + 1) % 3] + tie[(k + 2) % 3]) * TangentBlock::Identity();
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b) block(a, b) -= tie[3 - k - l] * frame[k][a].dot(frame[l][b]);
    return block;
  }
  /// The same without the ties.
  TangentBlock couple(int k, int l) const {
    return curvature * logArea[k] * logArea[l].transpose() -
           shapeWeight *
               (quotient[k] * logArea[l].transpose() + logArea[k] * quotient[l].transpose());
  }
};

/// frame[k]: the two tangents at corner k.
inline FaceExpansion expandFaceEnergy(const FaceTarget& target, const AreaEnergyWeights& weights,
                                      const std::array<Vector3, 3>& p,
                                      const std::array<std::array<Vector3, 2>, 3>& frame) {
  FaceExpansion e;
  std::array<Vector3, 3> gradientOfArea;
  const double s = e.solidAngle = solidAngle(p, gradientOfArea), inverse = 1 / s;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const Vector3 d = target.stiffness[j] * (p[k] - p[i]) + target.stiffness[i] * (p[k] - p[j]);
    e.logArea[k] =
        inverse * Tangent(gradientOfArea[k].dot(frame[k][0]), gradientOfArea[k].dot(frame[k][1]));
    e.quotient[k] = 0.5 * inverse * Tangent(d.dot(frame[k][0]), d.dot(frame[k][1]));
  }
  const double r = std::log(s / target.area), q = dirichletEnergy(target, p) / (2 * s);
  const double wa = target.weight * weights.area,
               wq = e.shapeWeight = static_cast<double>(target.shapeWeight) * weights.shape;
  e.energy = wa * r * r + wq * q;
  // D(x) / s: with K the stiffness, K/s - (Kx g^T + g (Kx)^T)/s^2 + 2 D g g^T / s^3, here all
  // over 2.
  e.slope = 2 * wa * r - wq * q;
  e.curvature = 2 * wa + 2 * wq * q;
  for (int k = 0; k < 3; ++k) e.tie[k] = 0.5 * wq * inverse * target.stiffness[k];
  return e;
}

}  // namespace sphere_propagation
