// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/area/area_restoration.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "vcg_ext/area/area_preserving_map.h"
#include "vcg_ext/area/area_schedule.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/base/rotation.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/sphere/map_measures.h"
#include "vcg_ext/sphere/repair/untangling.h"
#include "vcg_ext/sphere/spherical_triangle.h"

namespace sphere_propagation {
namespace {

/// What boundAreas takes: the areas that are wrong are in a few places, and need not be exact.
constexpr AreaSchedule localSchedule{0.75, 0.97, 0.995, 40};

/// The areas that `areaFor` makes of the solid angle of each face and its share of the surface (of
/// 4 pi), with the shapes of the map's faces.
template <class AreaFor>
std::vector<FaceTarget> targetsBetween(const ClosedSurface& surface, const Points& positions,
                                       const AreaFor& areaFor) {
  const Triangles& faces = surface.faces();
  std::vector<FaceTarget> targets = faceTargets(surface.vertices(), faces),
                          shapes = faceTargets(positions, faces);
  double sum = 0;
  for (size_t f = 0; f < targets.size(); ++f) {
    const auto at = [&](int k) {
      return Vector3(positions.row(faces(static_cast<Eigen::Index>(f), k)).transpose());
    };
    const double s = solidAngle(at(0), at(1), at(2));
    targets[f].area = areaFor(s, targets[f].area);
    targets[f].stiffness = shapes[f].stiffness;
    sum += targets[f].area;
  }
  const double mean = 4 * pi / static_cast<double>(targets.size());
  for (FaceTarget& target : targets) target = {target.area * 4 * pi / sum, mean, target.stiffness};
  return targets;
}

MappedSurface withTargets(const MappedSurface& map, std::vector<FaceTarget> targets,
                          const Progress& progress, const AreaSchedule& schedule) {
  const ClosedSurface& surface = map.surface();
  AreaMinimiser minimiser(surface, std::move(targets));
  Points positions = map.positions();
  const AreaEnergyWeights weights = energyWeights(AreaPreservingParameters{}.areaWeight);
  minimiseInStages(minimiser, weights, positions, progress, schedule);
  const Eigen::Matrix3d covariance = map.positions().transpose() *
                                     vertexAreas(surface.vertices(), surface.faces()).asDiagonal() *
                                     positions;
  positions *= bestRotation(covariance).transpose();
  report(progress, 1);
  return untangle(surface, std::move(positions))
      .map;  // turning may round a face away that was all but a line
}

}  // namespace

MappedSurface restoreArea(const MappedSurface& map, double amount, const Progress& progress) {
  requireRange("area restoration", amount, Range::between(0, 1));
  if (amount == 0) return map;
  const auto between = [&](double angle, double share) {
    return std::pow(angle, 1 - amount) * std::pow(share, amount);
  };
  return withTargets(map, targetsBetween(map.surface(), map.positions(), between), progress, {});
}

MappedSurface boundAreas(const MappedSurface& map, double bound) {
  requireRange("bound of areas", bound, Range::atLeast(1));
  bool beyond = false;
  const auto within = [&](double angle, double share) {
    const double area = std::min(std::max(angle, share / bound), share * bound);
    beyond = beyond || area != angle;
    return area;
  };
  std::vector<FaceTarget> targets = targetsBetween(map.surface(), map.positions(), within);
  return beyond ? withTargets(map, std::move(targets), {}, localSchedule) : map;
}

double squeezedShare(const MappedSurface& map, double bound) {
  requireRange("bound of areas", bound, Range::above(0));
  const Eigen::VectorXd ratios = areaRatios(map.surface(), map.positions()),
                        areas = faceAreas(map.surface().vertices(), map.faces());
  return (bound * ratios.array() < 1).select(areas, 0).sum() / areas.sum();
}

double boundOfSqueezing(const MappedSurface& map, double share) {
  const Eigen::VectorXd ratios = areaRatios(map.surface(), map.positions()),
                        areas = faceAreas(map.surface().vertices(), map.faces());
  std::vector<Eigen::Index> order(static_cast<size_t>(ratios.size()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return std::pair(ratios[a], a) < std::pair(ratios[b], b);
  });
  const double most = share * areas.sum();
  double squeezed = 0;
  for (const Eigen::Index f : order)
    if ((squeezed += areas[f]) > most) return std::max(1.0, 1 / ratios[f]);
  return 1;
}

}  // namespace sphere_propagation
