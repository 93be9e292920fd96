// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/area/area_restoration.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "vcg_ext/area/area_preserving_map.h"
#include "vcg_ext/area/area_schedule.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/base/rotation.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/sphere/repair/untangling.h"
#include "vcg_ext/sphere/spherical_triangle.h"

namespace sphere_propagation {
namespace {

/// The areas between those of the map and those of the surface, with the shapes of the map's faces.
std::vector<FaceTarget> targetsBetween(const ClosedSurface& surface, const Points& positions,
                                       double amount) {
  const Triangles& faces = surface.faces();
  std::vector<FaceTarget> targets = faceTargets(surface.vertices(), faces),
                          shapes = faceTargets(positions, faces);
  double sum = 0;
  for (size_t f = 0; f < targets.size(); ++f) {
    const auto at = [&](int k) {
      return Vector3(positions.row(faces(static_cast<Eigen::Index>(f), k)).transpose());
    };
    const double s = solidAngle(at(0), at(1), at(2));
    targets[f].area = std::pow(s, 1 - amount) * std::pow(targets[f].area, amount);
    targets[f].stiffness = shapes[f].stiffness;
    sum += targets[f].area;
  }
  const double mean = 4 * pi / static_cast<double>(targets.size());
  for (FaceTarget& target : targets) target = {target.area * 4 * pi / sum, mean, target.stiffness};
  return targets;
}

}  // namespace

MappedSurface restoreArea(const MappedSurface& map, double amount, const Progress& progress) {
  requireRange("area restoration", amount, Range::between(0, 1));
  if (amount == 0) return map;
  const ClosedSurface& surface = map.surface();
  AreaMinimiser minimiser(surface, targetsBetween(surface, map.positions(), amount));
  Points positions = map.positions();
  const AreaEnergyWeights weights = energyWeights(AreaPreservingParameters{}.areaWeight);
  minimiseInStages(minimiser, weights, positions, progress);
  const Eigen::Matrix3d covariance = map.positions().transpose() *
                                     vertexAreas(surface.vertices(), surface.faces()).asDiagonal() *
                                     positions;
  positions *= bestRotation(covariance).transpose();
  report(progress, 1);
  return untangle(surface, std::move(positions))
      .map;  // turning may round a face away that was all but a line
}

}  // namespace sphere_propagation
