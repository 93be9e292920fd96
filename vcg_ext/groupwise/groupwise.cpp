// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/groupwise/groupwise.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/random.h"
#include "vcg_ext/groupwise/description_length.h"
#include "vcg_ext/groupwise/moving_landmarks.h"
#include "vcg_ext/groupwise/opened_maps.h"
#include "vcg_ext/groupwise/population_anchors.h"
#include "vcg_ext/groupwise/population_model.h"
#include "vcg_ext/groupwise/population_pose.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

constexpr double nearlyAsClose = 1.25;  // of what opening makes of a map, to the closest
constexpr double longestMove = 0.5;     // of a landmark in one flow, in widths of the fields

// Of the population model.
constexpr int fieldFrequency = 4;
constexpr double fieldWidth = 0.3;
constexpr int flowsAnIteration = 2;
constexpr double modelDamping = 1e-3;
constexpr double defaultPrecision = 1000;
/// Below this variance, in squared radii, shapes are the same but for rounding.
constexpr double noVariance = 1e-20;

// Of the description length: fields from coarse to fine.
struct Level {
  int frequency;
  double width;
};
constexpr Level levels[]{{2, 0.6}, {3, 0.4}, {4, 0.3}};
constexpr double lengthDamping = 0.05, noiseVariance = 1e-4;

class Population {
 public:
  Population(const std::vector<MappedSurface>& surfaces, const GroupwiseParameters& parameters,
             ThreadPool& pool)
      : parameters_(parameters),
        pool_(pool),
        sphere_(std::make_shared<const Icosphere>(icosphere(parameters.frequency))) {
    double area = 0;
    for (const MappedSurface& surface : surfaces)
      area += faceAreas(surface.surface().vertices(), surface.faces()).sum();
    radius_ = radiusOfSphere(area / static_cast<double>(surfaces.size()));
    shapes_ = pool.makeEach(static_cast<int>(surfaces.size()), [&](int k) {
      return std::make_unique<MovingLandmarks>(scaled(surfaces[static_cast<size_t>(k)]), sphere_);
    });
  }

  /// Before anything moved. map: of the same surface.
  void replace(int k, const MappedSurface& map) {
    shapes_[static_cast<size_t>(k)] = std::make_unique<MovingLandmarks>(scaled(map), sphere_);
  }
  /// What replace would make of a shape's landmarks.
  SurfaceLandmarks landmarksOf(const MappedSurface& map) const {
    return LandmarkReader(scaled(map)).read(sphere_->vertices);
  }

  int count() const { return static_cast<int>(shapes_.size()); }
  double radius() const { return radius_; }
  MovingLandmarks& shape(int k) { return *shapes_[static_cast<size_t>(k)]; }
  const Triangles& faces() const { return sphere_->faces; }

  PopulationPose pose() const { return poseOf(points(), sphere_->faces, parameters_.alignment); }

  PopulationPose firstPose() const {
    return sphere_propagation::firstPose(points(), normals(), sphere_->faces, parameters_.alignment,
                                         pool_);
  }

  PopulationPose poseAfter(const PopulationPose& pose) const {
    return poseBySurfaces(points(), normals(), sphere_->faces, parameters_.alignment, pose, pool_);
  }

  std::vector<Points> points() const {
    std::vector<Points> all;
    all.reserve(shapes_.size());
    for (const auto& shape : shapes_) all.push_back(shape->landmarks().points);
    return all;
  }

  std::vector<Points> normals() const {
    std::vector<Points> all;
    all.reserve(shapes_.size());
    for (const auto& shape : shapes_) all.push_back(shape->landmarks().normals);
    return all;
  }

  /// Of the landmarks, as they are aligned.
  Points normals(const PopulationPose& pose, int k) const {
    const auto i = static_cast<size_t>(k);
    return (shapes_[i]->landmarks().normals * pose.turns[i].transpose()).rowwise().normalized();
  }

  /// Where the landmarks of a shape are by now, in the frame of a pose that is a little older.
  Points aligned(const PopulationPose& pose, const std::vector<Points>& then, int k) const {
    const auto i = static_cast<size_t>(k);
    return pose.shapes[i] +
           Points((shapes_[i]->landmarks().points - then[i]) * pose.turns[i].transpose());
  }

  /// The user's, where they are by now. sets, deviation: in the surfaces' unit.
  PopulationAnchors anchors(const std::vector<AnchorSet>& sets, double deviation) const {
    std::vector<MappedSurface> maps;
    std::vector<AnchorSet> scaled = sets;
    for (const auto& shape : shapes_) maps.push_back(shape->surface());
    for (AnchorSet& set : scaled)
      for (auto& [name, point] : set) point /= radius_;
    return {scaled, maps, deviation / radius_, sphere_};
  }

  /// In the frame of the shapes, not of a pose.
  std::vector<std::vector<PlacedAnchor>> placed(const PopulationAnchors& anchors,
                                                const Eigen::VectorXd& trust) const {
    return anchors.placed(pool_.makeEach(count(),
                                         [&](int k) -> Points {
                                           const auto i = static_cast<size_t>(k);
                                           return shapes_[i]->undone(anchors.directions(i));
                                         }),
                          trust);
  }

  /// By shape, the mean distance of its anchors from the common places; NaN where it has none.
  std::vector<double> distancesOf(const PopulationAnchors& anchors, const Eigen::VectorXd& trust) {
    const std::vector<std::vector<PlacedAnchor>> there = placed(anchors, trust);
    return pool_.makeEach(count(), [&](int k) {
      const auto i = static_cast<size_t>(k);
      if (there[i].empty()) return std::nan("");
      const Points here = shapes_[i]->read(shapes_[i]->followed(directionsOf(there[i])));
      return (here - anchors.points(i)).rowwise().norm().mean();
    });
  }

 private:
  MappedSurface scaled(const MappedSurface& map) const {
    return map.of(map.surface().withVertices(map.surface().vertices() / radius_));
  }

  const GroupwiseParameters& parameters_;
  ThreadPool& pool_;
  std::shared_ptr<const Icosphere> sphere_;
  double radius_ = 1;
  std::vector<std::unique_ptr<MovingLandmarks>> shapes_;
};

/// Opens the maps that squeeze, each as far as the others say that something was lost. Returns the
/// share of each surface that was opened.
///
/// Areas that differ because shapes do are no loss, and who opens them leads landmarks away from
/// the others. So of what opening makes of a map that is taken which opens most and brings the
/// shape to the mean of the maps that came, along its normals, nearly as close as any.
std::vector<double> openWhereLost(Population& population, const std::vector<MappedSurface>& given,
                                  Alignment alignment, ThreadPool& pool) {
  const std::vector<OpenedMap> opened = openedMaps(given, pool);
  std::vector<double> shares(given.size(), 0);
  if (std::all_of(opened.begin(), opened.end(),
                  [](const OpenedMap& one) { return one.squeezed == 0; }))
    return shares;
  const PopulationPose pose = population.pose();
  pool.forEach(population.count(), [&](int k) {
    const auto i = static_cast<size_t>(k);
    if (opened[i].squeezed == 0) return;
    const auto distanceOf = [&](const SurfaceLandmarks& landmarks) {
      return distanceAlongNormals(pose, landmarks.points, landmarks.normals, alignment);
    };
    const double asGiven = distanceOf(population.shape(k).landmarks()),
                 ofPockets = distanceOf(population.landmarksOf(opened[i].pockets)),
                 ofMost = distanceOf(population.landmarksOf(opened[i].map)),
                 enough = nearlyAsClose * std::min({asGiven, ofPockets, ofMost});
    if (ofMost > enough && ofPockets > enough) return;
    population.replace(k, ofMost <= enough ? opened[i].map : opened[i].pockets);
    shares[i] = opened[i].squeezed;
  });
  return shares;
}

double meanOf(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Weighted root mean square of the rows' lengths.
double rootMeanSquare(const Points& rows, const Eigen::VectorXd& weights) {
  return std::sqrt(rows.rowwise().squaredNorm().dot(weights));
}

/// From where a shape has the common places of its anchors to where the user says that they are.
Pulls pullsOf(const std::vector<PlacedAnchor>& anchors, MovingLandmarks& shape,
              const PopulationPose& pose, int k, const Points& then, double precision) {
  const auto count = static_cast<Eigen::Index>(anchors.size());
  Pulls pulls{shape.followed(directionsOf(anchors)), Points(count, 3), Eigen::VectorXd(count)};
  const Points here = shape.read(pulls.directions);
  for (Eigen::Index a = 0; a < count; ++a) {
    const PlacedAnchor& anchor = anchors[static_cast<size_t>(a)];
    pulls.displacements.row(a) =
        (anchor.point - pose.aligned(static_cast<size_t>(k), then, here.row(a).transpose()))
            .transpose();
    pulls.weights[a] = shareOf(anchor, precision);
  }
  return pulls;
}

/// The model is learnt, and the landmarks flow to where it expects them. Returns how far they were;
/// the pose gets the trust that was found.
double improveByModel(Population& population, PopulationPose& pose,
                      const PopulationAnchors& anchors,
                      const std::shared_ptr<const SphereFields>& fields,
                      const PopulationModelParameters& parameters, ThreadPool& pool,
                      Eigen::VectorXd& residuals) {
  const int count = population.count();
  const std::vector<Points> then = population.points();
  std::vector<Points> normals =
      pool.makeEach(count, [&](int k) -> Points { return population.normals(pose, k); });
  std::vector<std::vector<PlacedAnchor>> placed;
  if (!anchors.empty()) {
    placed = population.placed(anchors, pose.trust);
    for (size_t k = 0; k < placed.size(); ++k)
      for (PlacedAnchor& anchor : placed[k]) anchor.point = pose.aligned(k, then[k], anchor.point);
  }
  const PopulationFit fit = fitPopulation(pose, normals, parameters, pool, placed);
  residuals = fit.residuals;
  pose.trust = fit.trust;
  const double trusted = fit.trust.sum();
  double far = 0;
  for (int flow = 0; flow < flowsAnIteration; ++flow) {
    std::vector<Points> gaps = pool.makeEach(count, [&](int k) -> Points {
      const auto i = static_cast<size_t>(k);
      if (flow > 0) normals[i] = population.normals(pose, k);
      Points gap = fit.expected[i] - population.aligned(pose, then, k);
      const Eigen::VectorXd along = gap.cwiseProduct(normals[i]).rowwise().sum();
      gap -= along.asDiagonal() * normals[i];
      return gap;
    });
    // What all have in common says nothing: without this landmarks drift.
    Points common = Points::Zero(pose.mean.rows(), 3);
    for (int k = 0; k < count; ++k) common += fit.trust[k] / trusted * gaps[static_cast<size_t>(k)];
    std::vector<double> moves(gaps.size());
    pool.forEach(count, [&](int k) {
      const auto i = static_cast<size_t>(k);
      gaps[i] -= common;
      moves[i] = rootMeanSquare(gaps[i], pose.weights);
      MovingLandmarks& shape = population.shape(k);
      const Pulls pulls =
          placed.empty() ? Pulls() : pullsOf(placed[i], shape, pose, k, then[i], fit.precision);
      shape.move(fields,
                 shape.fieldFor(*fields, pose.turns[i], gaps[i], pose.weights, modelDamping, pulls),
                 longestMove * fields->width());
    });
    if (flow == 0) far = meanOf(moves);
  }
  return far;
}

/// One sweep over the shapes in random order: each moves to where the description length, as a
/// square in that shape, is least. Returns how far landmarks moved.
double improveByLength(Population& population, const PopulationPose& pose,
                       const std::shared_ptr<const SphereFields>& fields,
                       const DescriptionLength& length, std::mt19937& random) {
  const int count = population.count();
  std::vector<int> order(static_cast<size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  for (size_t i = order.size(); i > 1; --i)
    std::swap(order[i - 1],
              order[static_cast<size_t>(uniformNumber(random) * static_cast<double>(i))]);
  const std::vector<Points> then = population.points();
  std::vector<Points> displacements;
  for (const Points& shape : pose.shapes) displacements.push_back(shape - pose.mean);
  std::vector<double> moves;
  for (const int k : order) {
    const auto i = static_cast<size_t>(k);
    if (!(length.pull(k, k) > 0)) continue;
    Points pull = Points::Zero(pose.mean.rows(), 3);
    for (int j = 0; j < count; ++j)
      pull += length.pull(k, j) * displacements[static_cast<size_t>(j)];
    const Points target = -pull / length.pull(k, k);
    population.shape(k).move(
        fields,
        population.shape(k).fieldFor(*fields, pose.turns[i], target, pose.weights, lengthDamping),
        longestMove * fields->width());
    const Points there = population.aligned(pose, then, k) - pose.mean;
    moves.push_back(rootMeanSquare(there - displacements[i], pose.weights));
    displacements[i] = there;
  }
  return moves.empty() ? 0 : meanOf(moves);
}

}  // namespace

void requireValid(const GroupwiseParameters& parameters) {
  requireRange("number of iterations", parameters.iterations, Range::between(1, 1000));
  requireRange("surface precision", parameters.surfacePrecision, Range::between(0, 1e6));
  requireRange("number of prior shapes", parameters.priorShapes, Range::between(0.01, 1e6));
  requireRange("frequency", parameters.frequency, Range::between(3, 30));
  requireRange("standard deviation of anchors", parameters.anchorDeviation, Range::atLeast(0));
}

Groupwise optimiseGroupwise(const std::vector<MappedSurface>& surfaces, ThreadPool& pool,
                            const GroupwiseParameters& parameters, const Progress& progress) {
  requireValid(parameters);
  requireRange("number of shapes", static_cast<double>(surfaces.size()),
               Range::atLeast(minGroupwiseShapes));
  Population population(surfaces, parameters, pool);
  const std::vector<double> opened =
      openWhereLost(population, surfaces, parameters.alignment, pool);
  report(progress, 0.05);
  const int count = population.count();
  const std::vector<Points> first = population.points();
  const double radius = population.radius();
  PopulationPose pose = population.pose();

  Groupwise result;
  result.varianceBefore = pose.variance() * radius * radius;
  Eigen::VectorXd residuals = Eigen::VectorXd::Zero(count);
  std::vector<double> distances;  // of anchors
  const auto working = [&](int i) { return 0.05 + 0.85 * i / parameters.iterations; };
  if (parameters.objective == GroupwiseObjective::PopulationModel) {
    const auto fields = std::make_shared<const SphereFields>(fieldFrequency, fieldWidth);
    PopulationModelParameters model;
    model.priorShapes = parameters.priorShapes;
    model.surfacePrecision = result.surfacePrecision =
        parameters.surfacePrecision > 0 ? parameters.surfacePrecision : defaultPrecision;
    const PopulationAnchors anchors =
        population.anchors(parameters.anchors, parameters.anchorDeviation);
    pose = population.firstPose();
    for (int i = 0; i < parameters.iterations && pose.variance() > noVariance; ++i) {
      report(progress, working(i));
      result.moves.push_back(
          radius * improveByModel(population, pose, anchors, fields, model, pool, residuals));
      pose = population.poseAfter(pose);
    }
    if (!anchors.empty()) distances = population.distancesOf(anchors, pose.trust);
  } else {
    std::mt19937 random(0);
    constexpr int levelCount = sizeof(levels) / sizeof(levels[0]);
    int level = -1;
    std::shared_ptr<const SphereFields> fields;
    DescriptionLength length = descriptionLengthOf(pose, noiseVariance);
    result.costs.push_back(length.cost);
    for (int i = 0; i < parameters.iterations; ++i) {
      report(progress, working(i));
      if (const int next = i * levelCount / parameters.iterations; next != level) {
        level = next;
        fields = std::make_shared<const SphereFields>(levels[level].frequency, levels[level].width);
      }
      result.moves.push_back(radius * improveByLength(population, pose, fields, length, random));
      pose = population.pose();
      length = descriptionLengthOf(pose, noiseVariance);
      result.costs.push_back(length.cost);
    }
  }
  result.varianceAfter = pose.variance() * radius * radius;

  report(progress, working(parameters.iterations));
  const std::vector<FollowedMap> maps =
      pool.makeEach(count, [&](int k) { return population.shape(k).map(); });
  const std::vector<Points> last = population.points();
  for (int k = 0; k < count; ++k) {
    const auto i = static_cast<size_t>(k);
    const Eigen::VectorXd moved = (last[i] - first[i]).rowwise().norm();
    result.shapes.push_back({maps[i].map.of(surfaces[i].surface()),
                             radius * moved.dot(pose.weights), radius * residuals[k],
                             maps[i].repairedFaces, maps[i].share, pose.trust[k], opened[i],
                             distances.empty() ? std::nan("") : radius * distances[i]});
  }
  report(progress, 1);
  return result;
}

}  // namespace sphere_propagation
