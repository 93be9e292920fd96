// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Laying one shape on another, whatever poses the two are in.

#include <memory>
#include <vector>

#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/mesh/vertex_locator.h"
#include "vcg_ext/registration/rigid_alignment.h"

namespace sphere_propagation {

/// A surface, ready to be laid on others: about 100 vertices spread evenly over it, its principal
/// axes, and what closest points are found with.
class AlignedShape {
 public:
  explicit AlignedShape(const ClosedSurface& surface);

  const Points& samples() const { return samples_; }  ///< #S by 3, where the surface lies
  const Vector3& centre() const { return centre_; }   ///< by area: vertices lie as the mesh likes
  double radius() const { return radius_; }           ///< of the sphere of the same area
  double volume() const { return volume_; }           ///< enclosed
  /// Of the surface, for whoever needs one, too: building it costs more than the rest.
  const std::shared_ptr<const SurfaceLocator>& locator() const { return surface_; }

 private:
  friend RigidMotion refinedByPlanes(const RigidMotion&, const AlignedShape&, const AlignedShape&,
                                     Eigen::Index, double);
  friend RigidMotion motionByAxes(const AlignedShape&, const AlignedShape&);
  friend RigidMotion motionFromAnywhere(const AlignedShape&, const AlignedShape&);
  friend double shapeDistance(const AlignedShape&, const AlignedShape&, const RigidMotion&);

  AlignedShape(const ClosedSurface& surface, const Eigen::VectorXd& areas);  // of the vertices

  Vector3 centre_;
  double radius_, volume_;
  Eigen::Matrix3d axes_;  // columns, by falling variance, right-handed
  Points samples_;        // each as far as possible from those before
  VertexLocator vertices_;
  Points normals_;  // of the vertices
  Triangles faces_;
  std::shared_ptr<const SurfaceLocator> surface_;
};

std::vector<AlignedShape> alignedShapes(const std::vector<ClosedSurface>& surfaces,
                                        ThreadPool& pool);

/// The rigid motion that lays `from` on `to`, by closest points from the best of five poses: as
/// they are turned, and the four that lay principal axes on principal axes, centres together.
/// Quick; right where shapes have axes.
RigidMotion motionByAxes(const AlignedShape& from, const AlignedShape& to);

/// The same from the best few of 65 poses, with the sixty rotations of the icosahedron relative to
/// the axes besides: axes of shapes that are nearly round, or that differ much, say little. The
/// best is refined by point-to-plane distances of up to 1000 vertices (Y. Chen and G. Medioni,
/// Object modelling by registration of multiple range images, 1992): slides along the surface that
/// closest points hardly see end where the shapes fit.
RigidMotion motionFromAnywhere(const AlignedShape& from, const AlignedShape& to);

/// Root mean square distance of the samples of one from the surface of the other, and the other way
/// round, averaged. motion: how `from` is moved.
double shapeDistance(const AlignedShape& from, const AlignedShape& to,
                     const RigidMotion& motion = {});

/// What no motion, nor a reflection, makes the distance of the shapes much smaller than: the
/// difference of their volumes has to lie between them, spread over the larger of the two at best.
double minShapeDistance(const AlignedShape& a, const AlignedShape& b);

}  // namespace sphere_propagation
