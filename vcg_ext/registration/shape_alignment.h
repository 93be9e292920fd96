// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Laying one shape on another, whatever poses the two are in.

#include "vcg_ext/registration/prepared_surface.h"
#include "vcg_ext/registration/rigid_alignment.h"

namespace sphere_propagation {

/// The rigid motion that lays `from` on `to`, by closest points from the best of five poses: as
/// they are turned, and the four that lay principal axes on principal axes, centres together.
/// Quick; right where shapes have axes.
RigidMotion motionByAxes(const PreparedSurface& from, const PreparedSurface& to);

/// The same from the best few of 65 poses, with the sixty rotations of the icosahedron relative to
/// the axes besides: axes of shapes that are nearly round, or that differ much, say little. The
/// best is refined by point-to-plane distances of up to 1000 vertices (Y. Chen and G. Medioni,
/// Object modelling by registration of multiple range images, 1992): slides along the surface that
/// closest points hardly see end where the shapes fit.
RigidMotion motionFromAnywhere(const PreparedSurface& from, const PreparedSurface& to);

/// Root mean square distance of the samples of one from the surface of the other, and the other way
/// round, averaged. motion: how `from` is moved.
double shapeDistance(const PreparedSurface& from, const PreparedSurface& to,
                     const RigidMotion& motion = {});

/// What no motion, nor a reflection, makes the distance of the shapes much smaller than: the
/// difference of their volumes has to lie between them, spread over the larger of the two at best.
double minShapeDistance(const PreparedSurface& a, const PreparedSurface& b);

}  // namespace sphere_propagation
