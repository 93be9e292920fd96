// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Point location on the sphere: the inverse of a map.

#include "vcg_ext/mesh/face_tree.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

/// Finds the face of a map under any direction. Built once, asked often: about 1 microsecond a
/// query. Copies what it needs.
///
/// The answer is the flat triangle of the face's sphere positions that the ray from the centre
/// pierces. Of a valid map these triangles enclose the centre without a gap, so every direction has
/// one, be it a pole, a vertex or on an edge.
class SphereLocator {
 public:
  explicit SphereLocator(const MappedSurface& surface);

  /// direction: any length but zero. Returns face and barycentric weights w (none negative, sum 1)
  /// with w_0 a + w_1 b + w_2 c along `direction`, for the sphere positions a, b, c of its corners;
  /// distance is 0. Where faces meet, the one in which the smallest weight is largest (as
  /// computed), and of equals the smallest index. Throws ParameterError when the direction is zero
  /// or not finite, MapError should rounding leave no face under it, which a valid map rules out.
  SurfacePoint locate(const Vector3& direction) const;

 private:
  FaceTree tree_;
};

}  // namespace sphere_propagation
