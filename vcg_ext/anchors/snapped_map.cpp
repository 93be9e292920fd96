// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/anchors/snapped_map.h"

#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/icosphere.h"

namespace sphere_propagation {

SnappedMap snapToLandmarks(const MappedSurface& map, const std::vector<SurfacePoint>& points,
                           const std::vector<std::string>& names) {
  const Points vertices = icosphere(snapFrequency).vertices;
  if (static_cast<Eigen::Index>(points.size()) > vertices.rows())
    throw ArgumentError("There are more anchors than landmarks.");
  // Cosines; what is taken drops out.
  constexpr double taken = -2;
  Eigen::MatrixXd nearness(vertices.rows(), points.size());
  for (size_t k = 0; k < points.size(); ++k)
    nearness.col(static_cast<Eigen::Index>(k)) = vertices * placeOf(map, points[k]);
  std::vector<int> landmarks(points.size());
  std::vector<Vector3> targets(points.size());
  for (size_t done = 0; done < points.size(); ++done) {
    Eigen::Index vertex = 0, k = 0;
    nearness.maxCoeff(&vertex, &k);
    nearness.row(vertex).setConstant(taken);
    nearness.col(k).setConstant(taken);
    landmarks[static_cast<size_t>(k)] = static_cast<int>(vertex);
    targets[static_cast<size_t>(k)] = vertices.row(vertex).transpose();
  }
  return {holdExactly(map, points, targets, names).map, std::move(landmarks)};
}

}  // namespace sphere_propagation
