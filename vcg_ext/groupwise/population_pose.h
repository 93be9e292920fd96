// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The frame that a population is looked at in: its shapes aligned, and their mean.

#include <vector>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/model/procrustes.h"

namespace sphere_propagation {

/// The fewest shapes of which one can be told from the others.
constexpr int minTrustedShapes = 5;

/// 1 up to `full`, 0 from twice that on, linear between them: without a step, by which maps would
/// change at the last digit of a surface.
double trustIn(double distance, double full);

struct PopulationPose {
  std::vector<Eigen::Matrix3d> turns;  ///< one per shape: rotation times scale
  std::vector<Points> shapes;          ///< aligned landmarks, #N by 3
  Points mean;                         ///< #N by 3
  Eigen::VectorXd weights;  ///< #N: the share of each landmark in the shapes' area, sum 1
  Eigen::VectorXd trust;    ///< #K: how much each shape counts for the mean and all else that they
                            ///< have in common, 0 to 1

  /// Where a point of a shape lies when that is aligned. landmarks: the shape's, as they were.
  Vector3 aligned(size_t k, const Points& landmarks, const Vector3& point) const {
    return shapes[k].row(0).transpose() + turns[k] * (point - landmarks.row(0).transpose());
  }

  /// The mean of the squared distances from the mean shape, weighted: the total variance (divisor
  /// the sum of trust).
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
/// whose landmarks may have moved since, with the trust that is put into them.
PopulationPose poseBySurfaces(const std::vector<Points>& landmarks,
                              const std::vector<Points>& normals, const Triangles& faces,
                              Alignment alignment, const PopulationPose& from, ThreadPool& pool);

/// The pose to begin with: found by poseBySurfaces from the shapes as they lie where that lays the
/// surfaces on each other nearly as well as from Procrustes alignment (the frame that they lie in
/// means something then, and tells apart what shapes alone do not, as the axes of an ellipsoid),
/// else from that. Of five shapes or more, those that lie more than twice as far off the mean as
/// three quarters do count there for no more than that, and are trusted less, from four times on
/// not at all.
PopulationPose firstPose(const std::vector<Points>& landmarks, const std::vector<Points>& normals,
                         const Triangles& faces, Alignment alignment, ThreadPool& pool);

/// How far a shape, laid on the mean of a pose by Procrustes alignment, is from it along its own
/// normals: root mean square by the pose's weights.
double distanceAlongNormals(const PopulationPose& pose, const Points& landmarks,
                            const Points& normals, Alignment alignment);

}  // namespace sphere_propagation
