// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// An initial map close to conformal: the harmonic map with cotangent weights.
///
/// S. Haker, S. Angenent, A. Tannenbaum, R. Kikinis, G. Sapiro, M. Halle, Conformal surface
/// parameterization for texture mapping, IEEE Transactions on Visualization and Computer Graphics
/// 6(2), 2000: take a face out, map the rest to the plane by a Laplace system with a dipole on that
/// face, project to the sphere. Then areas are balanced by a Moebius transformation
/// (moebius_balancing.h), which costs no angles.
///
/// Where the cotangents of an edge are negative together (obtuse faces) the map may fold. With all
/// weights positive the plane map is a drawing of W. T. Tutte (How to draw a graph, 1963) inside
/// the triangle that was taken out, and folds nowhere; on the sphere a few faces still can: thin
/// ones near the puncture, whose circumscribed circle is larger than a hemisphere, and ones below
/// rounding, deep in limbs. So the true cotangents come first, for the sake of angles, and the
/// clamped ones where no map comes of them.

#include <Eigen/SparseCore>
#include <limits>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/mesh/closed_surface.h"

namespace sphere_propagation {

/// The Laplace matrix with cotangent weights, #V by #V, symmetric, rows sum to zero: entry (v, w)
/// is
///   -(cot alpha + cot beta) / 2, alpha and beta the angles opposite to the edge (v, w).
/// The cotangents of a face so thin that one would be beyond 100 are scaled down together, and 1e-4
/// is added to every cotangent: the matrix is positive definite but for constants, whatever the
/// faces. minWeight: smaller (cot alpha + cot beta) / 2 are raised to it; minus infinity leaves
/// them.
Eigen::SparseMatrix<double> cotangentLaplacian(
    const ClosedSurface& surface, double minWeight = -std::numeric_limits<double>::infinity());

/// A position for each vertex, #V by 3 unit vectors, not necessarily a valid map.
///
/// The puncture: well-shaped faces (all angles above half a radian where there are any) are tried,
/// one near the middle of the shape first, then each as far as possible from those before, until
/// the positions certify as a map; after twelve, the same with weights of at least 0.01. When none
/// does, the positions with the fewest flipped faces are it. One factorisation serves twelve.
///
/// Balanced: the mean of the positions, weighted by a third of the areas of the faces round each
/// vertex, is the centre of the sphere to within 1e-12. What freedom is left, a rotation, turns the
/// sphere as close to the shape as it goes (least squares with the same weights), so that the map
/// turns with the shape.
Points harmonicPositions(const ClosedSurface& surface);

}  // namespace sphere_propagation
