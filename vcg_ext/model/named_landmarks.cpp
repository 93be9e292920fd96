// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/named_landmarks.h"

#include <set>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

// Of a shape's diagonal. Files of points round less; landmarks lie a thousand times as far apart,
// so that no point lies there by chance.
constexpr double sameShare = 1e-5;

}  // namespace

std::map<std::string, Eigen::Index> namedLandmarks(
    const TrainingSet& shapes, const std::vector<std::map<std::string, Vector3>>& points) {
  if (points.size() != shapes.shapes().size())
    throw ArgumentError("Names of landmarks: points are needed for each shape.");
  std::map<std::string, std::set<Eigen::Index>> found;
  for (size_t k = 0; k < points.size(); ++k) {
    const Points& landmarks = shapes.shapes()[k].landmarks;
    const double same =
        sameShare * (landmarks.colwise().maxCoeff() - landmarks.colwise().minCoeff()).norm();
    for (const auto& [name, point] : points[k]) {
      Eigen::Index nearest = 0;
      const double squared =
          (landmarks.rowwise() - point.transpose()).rowwise().squaredNorm().minCoeff(&nearest);
      if (squared <= same * same) found[name].insert(nearest);
    }
  }
  std::map<std::string, Eigen::Index> named;
  for (const auto& [name, landmarks] : found)
    if (landmarks.size() == 1) named.emplace(name, *landmarks.begin());
  return named;
}

}  // namespace sphere_propagation
