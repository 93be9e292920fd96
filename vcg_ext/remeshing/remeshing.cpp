// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/remeshing/remeshing.h"

#include <algorithm>

#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/sphere/sphere_walk.h"

namespace sphere_propagation {
namespace {

/// Mean of distances weighted by areas, and their maximum.
class Samples {
 public:
  void add(double weight, double distance) {
    weights_ += weight;
    sum_ += weight * distance;
    max_ = std::max(max_, distance);
  }
  /// A mesh without any area has no mean of its own; then the maximum stands for it.
  double mean() const { return weights_ > 0 ? sum_ / weights_ : max_; }
  double max() const { return max_; }

 private:
  double weights_ = 0, sum_ = 0, max_ = 0;
};

SurfaceLocator locatorOf(const Points& vertices, const Triangles& faces,
                         const std::vector<int>& order) {
  return order.empty() ? SurfaceLocator(vertices, faces) : SurfaceLocator(vertices, faces, order);
}

int hint(const std::vector<int>& hints, Eigen::Index i) {
  return hints.empty() ? -1 : hints[static_cast<size_t>(i)];
}

}  // namespace

Remeshed remesh(const MappedSurface& surface, const Points& directions) {
  SphereWalk walk(surface);
  Remeshed result;
  result.landmarks.resize(directions.rows(), 3);
  result.faces.reserve(static_cast<size_t>(directions.rows()));
  for (Eigen::Index j = 0; j < directions.rows(); ++j) {
    const SurfacePoint found = walk.locate(directions.row(j).transpose());
    result.landmarks.row(j) =
        found.interpolate(surface.faces(), surface.surface().vertices()).transpose();
    result.faces.push_back(found.face);
  }
  return result;
}

std::vector<int> lidsOfLandmarks(const Remeshed& remeshed, const Triangles& faces,
                                 const std::vector<int>& lids) {
  std::vector<int> result(remeshed.faces.size(), 0);
  for (size_t j = 0; j < result.size(); ++j)
    for (int k = 0; k < 3 && result[j] == 0; ++k)
      result[j] = lids[static_cast<size_t>(faces(remeshed.faces[j], k))];
  return result;
}

SurfaceDistance surfaceDistance(const Points& landmarks, const Triangles& faces,
                                const ClosedSurface& surface, const DistanceHints& hints) {
  const Eigen::VectorXd area = faceAreas(landmarks, faces);
  const Eigen::VectorXd landmarkArea = vertexAreas(landmarks, faces);
  const SurfaceLocator onSurface =
      locatorOf(surface.vertices(), surface.faces(), hints.surfaceFaces);
  Samples there;
  for (Eigen::Index j = 0; j < landmarks.rows(); ++j)
    there.add(landmarkArea[j] / 4, hints.landmarksOnSurface
                                       ? 0
                                       : onSurface.closest(landmarks.row(j).transpose()).distance);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const Vector3 centroid =
        (landmarks.row(faces(f, 0)) + landmarks.row(faces(f, 1)) + landmarks.row(faces(f, 2)))
            .transpose() /
        3;
    there.add(area[f] * 3 / 4, onSurface.closest(centroid, hint(hints.nearCentroid, f)).distance);
  }

  const SurfaceLocator onLandmarks = locatorOf(landmarks, faces, hints.landmarkFaces);
  const Eigen::VectorXd surfaceArea = vertexAreas(surface.vertices(), surface.faces());
  Samples back;
  for (int v = 0; v < surface.vertexCount(); ++v)
    back.add(surfaceArea[v],
             onLandmarks.closest(surface.vertex(v), hint(hints.nearVertex, v)).distance);

  return {(there.mean() + back.mean()) / 2, std::max(there.max(), back.max())};
}

}  // namespace sphere_propagation
