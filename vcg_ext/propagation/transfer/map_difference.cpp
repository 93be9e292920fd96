// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/transfer/map_difference.h"

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "vcg_ext/base/error.h"
#include "vcg_ext/sphere/sphere_locator.h"

namespace sphere_propagation {

MapDifference differenceOf(const ClosedSurface& surface, const SphereMap& a, const SphereMap& b) {
  for (const SphereMap* map : {&a, &b})
    if (map->positions().rows() != surface.vertexCount())
      throw ParameterError("Maps of layer \"" + surface.name() +
                           "\" are compared, but one of them has " +
                           std::to_string(map->positions().rows()) + " positions for " +
                           std::to_string(surface.vertexCount()) + " vertices.");
  const SphereLocator under(surface, b);
  std::vector<double> distances, angles;
  for (int v = 0; v < surface.vertexCount(); ++v) {
    const Vector3 p = a.position(v), q = b.position(v);
    const Vector3 there = under.locate(p).interpolate(surface.faces(), surface.vertices());
    distances.push_back((there - surface.vertex(v)).norm());
    angles.push_back(std::atan2(p.cross(q).norm(), p.dot(q)) * 180 / pi);
  }
  return {residualOf(distances), residualOf(angles)};
}

}  // namespace sphere_propagation
