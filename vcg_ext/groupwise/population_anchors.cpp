// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/groupwise/population_anchors.h"

#include <map>
#include <string>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/sphere/sphere_locator.h"

namespace sphere_propagation {

Points directionsOf(const std::vector<PlacedAnchor>& anchors) {
  Points directions(static_cast<Eigen::Index>(anchors.size()), 3);
  for (Eigen::Index a = 0; a < directions.rows(); ++a)
    directions.row(a) = anchors[static_cast<size_t>(a)].direction.transpose();
  return directions;
}

PopulationAnchors::PopulationAnchors(const std::vector<AnchorSet>& sets,
                                     const std::vector<MappedSurface>& maps, double deviation,
                                     std::shared_ptr<const Icosphere> sphere)
    : sphere_(std::move(sphere)) {
  if (sets.empty()) return;
  if (sets.size() != maps.size())
    throw ArgumentError("There are anchors of " + std::to_string(sets.size()) + " shapes, but " +
                        std::to_string(maps.size()) + " shapes.");
  std::map<std::string, int> shared;
  for (const AnchorSet& set : sets)
    for (const auto& [name, point] : set) ++shared[name];
  for (auto name = shared.begin(); name != shared.end();)
    if (name->second < 2)
      name = shared.erase(name);
    else
      (name++)->second = count_++;
  if (empty()) return;
  for (size_t k = 0; k < sets.size(); ++k) {
    std::vector<int> numbers;
    std::vector<Vector3> given;
    for (const auto& [name, point] : sets[k])
      if (const auto its = shared.find(name); its != shared.end()) {
        numbers.push_back(its->second);
        given.push_back(point);
      }
    const auto rows = static_cast<Eigen::Index>(given.size());
    Points directions(rows, 3), points(rows, 3);
    double precision = 0;
    if (rows > 0) {
      const Points& vertices = maps[k].surface().vertices();
      const Triangles& faces = maps[k].faces();
      const SurfaceLocator surface(vertices, faces);
      for (Eigen::Index i = 0; i < rows; ++i) {
        const SurfacePoint at = surface.closest(given[static_cast<size_t>(i)]);
        points.row(i) = at.interpolate(faces, vertices).transpose();
        directions.row(i) =
            at.interpolate(faces, maps[k].positions()).stableNormalized().transpose();
      }
      const double sd = deviation > 0 ? deviation : meanEdgeLength(vertices, faces);
      precision = 1 / (sd * sd);
    }
    names_.push_back(std::move(numbers));
    directions_.push_back(std::move(directions));
    points_.push_back(std::move(points));
    precisions_.push_back(precision);
  }
}

std::vector<std::vector<PlacedAnchor>> PopulationAnchors::placed(
    const std::vector<Points>& there, const Eigen::VectorXd& trust) const {
  // Who is not trusted at all has a say where nobody else has one.
  constexpr double least = 1e-6;
  Points sums = Points::Zero(count_, 3);
  for (size_t k = 0; k < there.size(); ++k)
    for (size_t i = 0; i < names_[k].size(); ++i)
      sums.row(names_[k][i]) += (least + trust[static_cast<Eigen::Index>(k)]) *
                                there[k].row(static_cast<Eigen::Index>(i));
  const SphereLocator under(
      MappedSurface(ClosedSurface(sphere_->vertices, sphere_->faces), sphere_->vertices));
  std::vector<PlacedAnchor> common(static_cast<size_t>(count_));
  for (Eigen::Index a = 0; a < count_; ++a) {
    PlacedAnchor& anchor = common[static_cast<size_t>(a)];
    anchor.direction = sums.row(a).transpose().stableNormalized();
    if (!(anchor.direction.squaredNorm() > 0.5)) anchor.direction = Vector3::UnitZ();
    const SurfacePoint at = under.locate(anchor.direction);
    anchor.corners = sphere_->faces.row(at.face).transpose();
    anchor.weights = at.weights;
  }
  std::vector<std::vector<PlacedAnchor>> placed(there.size());
  for (size_t k = 0; k < there.size(); ++k)
    for (size_t i = 0; i < names_[k].size(); ++i) {
      PlacedAnchor anchor = common[static_cast<size_t>(names_[k][i])];
      anchor.point = points_[k].row(static_cast<Eigen::Index>(i)).transpose();
      anchor.precision = precisions_[k];
      placed[k].push_back(anchor);
    }
  return placed;
}

}  // namespace sphere_propagation
