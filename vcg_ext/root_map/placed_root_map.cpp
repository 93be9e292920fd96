// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/root_map/placed_root_map.h"

#include <Eigen/Geometry>
#include <utility>

#include "vcg_ext/area/area_preserving_map.h"
#include "vcg_ext/base/rotation.h"
#include "vcg_ext/sphere/repair/untangling.h"

namespace sphere_propagation {

PlacedRootMap placeAnchors(const MappedSurface& map, const std::vector<SurfacePoint>& points,
                           const std::vector<Vector3>& places,
                           const std::vector<std::string>& names, double areaWeight,
                           const Progress& progress, ThreadPool* pool) {
  if (points.empty()) return {map};
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (size_t k = 0; k < points.size(); ++k)
    covariance += places[k] * placeOf(map, points[k]).transpose();
  const Eigen::Matrix3d rotation = bestRotation(covariance);
  Points turned = map.positions() * rotation.transpose();
  turned.rowwise().normalize();
  // Turning may round a face away that was all but a line.
  const MappedSurface start = untangle(map.surface(), std::move(turned)).map;
  const ExactMap held = holdExactly(start, points, places, names);
  report(progress, 0.3);

  AreaPreservingParameters parameters;
  parameters.areaWeight = areaWeight;
  parameters.held.assign(static_cast<size_t>(map.vertexCount()), 0);
  for (const SurfacePoint& point : points)
    for (int k = 0; k < 3; ++k)
      parameters.held[static_cast<size_t>(map.faces()(point.face, k))] = 1;
  const MappedSurface even =
      makeAreaPreserving(held.map, parameters, part(progress, 0.3, 1), pool).map;
  // What is held was made unit length again: the last bits.
  return {holdExactly(even, points, places, names).map, Eigen::AngleAxisd(rotation).angle(),
          held.longestWay};
}

}  // namespace sphere_propagation
