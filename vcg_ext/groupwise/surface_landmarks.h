// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Landmarks of a mapped surface, and how they move when the place on the sphere that they are read
/// at does.

#include <vector>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/sphere/mapped_surface.h"
#include "vcg_ext/sphere/sphere_walk.h"

namespace sphere_propagation {

struct SurfaceLandmarks {
  Points points;                             ///< #N by 3
  Points normals;                            ///< #N by 3, the vertices' interpolated, unit
  std::vector<Eigen::Matrix3d> derivatives;  ///< of the point by the unit vector that it lies under
};

/// Reads landmarks off one surface, again and again. One per thread.
class LandmarkReader {
 public:
  explicit LandmarkReader(const MappedSurface& surface);

  const MappedSurface& surface() const { return surface_; }

  /// directions: #N by 3 unit vectors, best each near the one before.
  SurfaceLandmarks read(const Points& directions);

 private:
  MappedSurface surface_;
  Points normals_;
  SphereWalk walk_;
};

}  // namespace sphere_propagation
