// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/transfer/map_difference.h"

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "vcg_ext/sphere/sphere_locator.h"

namespace sphere_propagation {

MapDifference differenceOf(const MappedSurface& a, const MappedSurface& b) {
  const ClosedSurface& surface = a.surface();
  const SphereLocator under(b.of(surface));
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
