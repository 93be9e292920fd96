// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Handles of a surface, removed by way of a volume.

#include <vector>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/base/progress.h"

namespace sphere_propagation {

/// A surface made anew.
struct RemadeSurface {
  Points vertices;           ///< #V by 3
  Triangles faces;           ///< #F by 3; closed, outward, genus 0, one part
  std::vector<int> nearest;  ///< #V: the face of the former surface that is nearest
  double voxelSize = 0;      ///< of the volume
  long handles = 0;          ///< that it had
  long changedVoxels = 0;    ///< to remove them
};

/// A closed surface of any genus becomes a volume (a voxel is inside where a ray leaves the surface
/// an odd number of times), whose handles are removed where that changes the fewest voxels
/// (removeHandles), and a surface again (volumeSurface). Nothing of the mesh is kept, and what is
/// thinner than a voxel is lost.
///
/// vertices: #V by 3; faces: #F by 3, closed; voxelSize: 0 for three quarters of the mean edge
/// length, or what makes 10 million voxels. Throws what volumeSurface throws.
RemadeSurface withoutHandles(const Points& vertices, const Triangles& faces, double voxelSize = 0,
                             const Progress& progress = {});

}  // namespace sphere_propagation
