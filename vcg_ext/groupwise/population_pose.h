// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The frame that a population is looked at in: its shapes aligned, and their mean.

#include <vector>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/model/procrustes.h"

namespace sphere_propagation {

struct PopulationPose {
  std::vector<Eigen::Matrix3d> turns;  ///< one per shape: rotation times scale
  std::vector<Points> shapes;          ///< aligned landmarks, #N by 3
  Points mean;                         ///< #N by 3
  Eigen::VectorXd weights;  ///< #N: the share of each landmark in the shapes' area, sum 1

  /// The mean of the squared distances from the mean shape, weighted: the total variance (divisor
  /// K).
  double variance() const;
};

/// Generalised Procrustes alignment with area weights (procrustes.h). landmarks: two or more shapes
/// of #N by 3; faces: of the landmarks.
PopulationPose poseOf(const std::vector<Points>& landmarks, const Triangles& faces,
                      Alignment alignment);

/// The alignment that surfaces show, found from that of another pose. Landmarks that slid round an
/// axis look to Procrustes like a shape that was turned, and what it takes out nobody can put back.
/// So landmarks count only as points of a surface: each is compared with the nearest one of the
/// mean, along its normal (Y. Chen and G. Medioni, Object modelling by registration of multiple
/// range images, 1992). Turns cost something, so those that the normals do not determine, as of a
/// sphere, stay what they were. Minimised by turns, as Procrustes alignment is; frame and size are
/// fixed as there.
///
/// normals: of the landmarks as they are, unit, one #N by 3 per shape; from: of the same shapes,
/// whose landmarks may have moved since.
PopulationPose poseBySurfaces(const std::vector<Points>& landmarks,
                              const std::vector<Points>& normals, const Triangles& faces,
                              Alignment alignment, const PopulationPose& from, ThreadPool& pool);

/// The pose to begin with: found by poseBySurfaces from the shapes as they lie where that lays the
/// surfaces on each other nearly as well as from Procrustes alignment (the frame that they lie in
/// means something then, and tells apart what shapes alone do not, as the axes of an ellipsoid),
/// else from that.
PopulationPose firstPose(const std::vector<Points>& landmarks, const std::vector<Points>& normals,
                         const Triangles& faces, Alignment alignment, ThreadPool& pool);

}  // namespace sphere_propagation
