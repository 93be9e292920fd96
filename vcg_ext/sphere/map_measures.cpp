// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/map_measures.h"

#include <algorithm>
#include <cmath>

#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/mesh/usable_extent.h"
#include "vcg_ext/sphere/spherical_triangle.h"

namespace sphere_propagation {
Eigen::VectorXd areaRatios(const ClosedSurface& surface, const Points& positions) {
  const Eigen::VectorXd areas = faceAreas(surface.vertices(), surface.faces());
  const double total = areas.sum();
  Eigen::VectorXd ratios = Eigen::VectorXd::Ones(areas.size());
  for (int f = 0; f < surface.faceCount(); ++f) {
    if (areas[f] <= minFaceShare * total / static_cast<double>(areas.size())) continue;
    const auto at = [&](int k) {
      return Vector3(positions.row(surface.faces()(f, k)).transpose());
    };
    ratios[f] = solidAngle(at(0), at(1), at(2)) / (4 * pi) / (areas[f] / total);
  }
  return ratios;
}

Eigen::VectorXd vertexAreaRatios(const ClosedSurface& surface, const Points& positions) {
  const Eigen::VectorXd areas = faceAreas(surface.vertices(), surface.faces());
  const double total = areas.sum();
  Eigen::VectorXd onSphere = Eigen::VectorXd::Zero(surface.vertexCount()), onSurface = onSphere;
  for (int f = 0; f < surface.faceCount(); ++f) {
    const auto at = [&](int k) {
      return Vector3(positions.row(surface.faces()(f, k)).transpose());
    };
    const double angle = solidAngle(at(0), at(1), at(2));
    for (int k = 0; k < 3; ++k) {
      onSphere[surface.faces()(f, k)] += angle;
      onSurface[surface.faces()(f, k)] += areas[f];
    }
  }
  Eigen::VectorXd ratios = Eigen::VectorXd::Ones(surface.vertexCount());
  for (int v = 0; v < surface.vertexCount(); ++v)
    if (onSurface[v] > minFaceShare * total / static_cast<double>(areas.size()))
      ratios[v] = onSphere[v] / (4 * pi) / (onSurface[v] / total);
  return ratios;
}

MapMeasures measureMap(const ClosedSurface& surface, const Points& positions) {
  MapMeasures measures;
  measures.certificate = certify(surface.faces(), positions);
  const Eigen::VectorXd areas = faceAreas(surface.vertices(), surface.faces());
  const Eigen::VectorXd ratios = areaRatios(surface, positions);
  const Points onMesh = cornerAngles(surface.vertices(), surface.faces());
  const Points onSphere = cornerAngles(positions, surface.faces());
  double mean = 0, squares = 0, logs = 0, angles = 0, count = 0;
  const double least = minFaceShare * areas.mean();
  for (int f = 0; f < surface.faceCount(); ++f) {
    if (areas[f] <= least) continue;
    count += 1;
    mean += ratios[f];
    logs += std::fabs(std::log(std::max(ratios[f], 1e-12)));
    angles += (onMesh.row(f) - onSphere.row(f)).cwiseAbs().sum() / 3;
  }
  mean /= count;
  for (int f = 0; f < surface.faceCount(); ++f)
    if (areas[f] > least) squares += (ratios[f] - mean) * (ratios[f] - mean);
  measures.areaRatioSd = std::sqrt(squares / count);
  measures.areaLogMean = logs / count;
  measures.angleErrorMean = angles / count * 180 / pi;
  return measures;
}

}  // namespace sphere_propagation
