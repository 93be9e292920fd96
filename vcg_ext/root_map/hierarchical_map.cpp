// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/root_map/hierarchical_map.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "vcg_ext/area/area_minimiser.h"
#include "vcg_ext/area/area_schedule.h"
#include "vcg_ext/area/local_step.h"
#include "vcg_ext/base/rotation.h"
#include "vcg_ext/mesh/hierarchy/collapsible_mesh.h"
#include "vcg_ext/mesh/hierarchy/simplification.h"
#include "vcg_ext/mesh/hierarchy/spatial_order.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/sphere/kernel_placement.h"

namespace sphere_propagation {
namespace {

/// What is done on which level. Chosen by the figures and times of scripts/measure-root-map.
struct HierarchySchedule {
  // Levels: how many vertices are there when all of them are moved.
  int firstLevel = 6;
  /// The next level has so many times as many vertices as the last.
  double levelRatio = 2;
  /// Few vertices cost nothing, and what goes wrong among them takes long to mend later: below this
  /// number all vertices are moved more often, and local steps go first.
  int coarse = 200;
  double coarseRatio = 1.3;
  int medium = 10 * coarse;  ///< below this number there are more steps than above

  // Global steps on a level, at most.
  int coarseSteps = 30;
  int mediumSteps = 10;
  int fineSteps = 3;
  /// A step that leaves this share of the energy ends a level: what is left moves more cheaply
  /// later.
  double levelEnd = 0.985;

  // Energy on a level.
  /// Coarse triangles say little about the surface's: those of equilateral ones count for more.
  ShapeTrust coarseTrust{0.1, 0.02};
  /// Weight of the shape term beside an area term of 1, up to `manyVertices`; then it falls with
  /// this power of their number: the finer the level, the less has to be moved, and the less the
  /// shapes need to be minded.
  double shape = 0.05;
  double manyVertices = 1000;
  double shapePower = 0.7;

  // Placing vertices that come back.
  int stepsOfNewVertex = 3;  ///< local ones, while its neighbours stand still
  /// So often, where a kernel is empty. Each time the shapes count this many times as much.
  int attempts = 4;
  double shapeGain = 10;

  // The last level.
  /// Of larger meshes more would cost much and be seen in the figures alone.
  int large = 100000;
  /// The first stage has this share of the weight that the shapes would have on such a level: the
  /// areas are all but home.
  double firstShape = 0.5;
  double onTheWay = 0.96, atTheEnd = 0.998, atTheEndOfLarge = 0.985;  ///< see AreaSchedule
  int iterations = 100, iterationsOfLarge = 60;                       ///< see AreaSchedule
  /// Where shapes count much, their minimum lies far above 0: what a step gains looks small.
  double atTheEndOfShapes = 0.9997;

  // Once more as from any other start, where the areas are not home: it costs ten times the rest.
  int rounds = 3;
  /// Mean squared logarithm of the area ratio that is good enough; again only where much is left.
  double good = 1e-3, goodAgain = 5e-3;
  double roundsEnd = 0.8;  ///< a round that leaves this share of the energy is the last

  // Shares of the time, for the progress.
  double simplified = 0.12, allBack = 0.48, minimised = 0.7;

  int stepsOn(int vertices) const {
    return vertices < coarse ? coarseSteps : vertices < medium ? mediumSteps : fineSteps;
  }
  double nextLevel(int vertices) const {
    return (vertices < coarse ? coarseRatio : levelRatio) * vertices;
  }
  double shapeOn(int vertices) const {
    return shape * std::min(1.0, std::pow(manyVertices / vertices, shapePower));
  }
};
constexpr HierarchySchedule schedule;

class Refinement {
 public:
  Refinement(const ClosedSurface& surface, const AreaEnergyWeights& weights, ThreadPool& pool)
      : surface_(surface), final_(weights), pool_(pool), order_(spatialOrder(surface.vertices())) {
    mesh_.emplace(surface, order_);
    for (int f = 0; f < surface.faceCount(); ++f) totalArea_ += mesh_->area(3 * f);
    positions_.resize(surface.vertexCount(), 3);
  }

  HierarchicalResult run(const Progress& progress) {
    const std::vector<int> rounds = simplify(*mesh_, pool_, part(progress, 0, schedule.simplified));
    layTetrahedron();
    const Progress refining = part(progress, schedule.simplified, schedule.allBack);
    double next = schedule.firstLevel;
    for (auto round = rounds.rbegin(); round != rounds.rend(); ++round) {
      bringBack(*round);
      const int n = mesh_->vertexCount();
      if (n >= next && n < mesh_->allVertices()) {
        improve(weightsAt(n), schedule.stepsOn(n));
        next = schedule.nextLevel(n);
        report(refining, static_cast<double>(n) / mesh_->allVertices());
      }
    }
    finish(part(progress, schedule.allBack, 1));
    return std::move(result_);
  }

 private:
  AreaEnergyWeights weightsAt(int vertices) const {
    return {1, std::max(schedule.shapeOn(vertices), final_.area > 0 ? final_.shape : 0)};
  }

  void layTetrahedron() {
    const std::array<int, 4> corners = mesh_->tetrahedron();
    const Eigen::Matrix<double, 4, 3> regular = regularTetrahedron();
    for (int i = 0; i < 4; ++i) positions_.row(corners[i]) = regular.row(i);
  }

  void gather(int v, VertexStar& star) const {
    star.rim.clear();
    star.targets.clear();
    const double mean = 4 * pi / (2 * mesh_->vertexCount() - 4);
    const int first = mesh_->someHalfEdge(v);
    int h = first;
    do {
      const int w = mesh_->target(h), next = mesh_->turned(h);
      star.rim.emplace_back(positions_.row(w).transpose());
      star.targets.emplace_back(
          4 * pi * mesh_->area(h) / totalArea_, mean,
          faceStiffness({mesh_->point(v), mesh_->point(w), mesh_->point(mesh_->target(next))},
                        schedule.coarseTrust));
      h = next;
    } while (h != first);
  }

  /// Takes back the last `count` collapses and places the vertices.
  void bringBack(int count) {
    std::vector<int> halfEdges, back;
    std::vector<char> lost;
    for (int attempt = 1;; ++attempt) {
      back.clear();
      halfEdges.clear();
      for (int i = 0; i < count; ++i) {
        halfEdges.push_back(mesh_->lastCollapse());
        back.push_back(mesh_->undo());
      }
      placeAll(back, lost);
      const auto found = std::find(lost.begin(), lost.end(), 1);
      if (found == lost.end()) {
        if (attempt > 1) improve(weightsAt(mesh_->vertexCount()), schedule.coarseSteps);
        return;
      }
      if (attempt == schedule.attempts) {
        const int v = order_[back[static_cast<size_t>(found - lost.begin())]];
        throw MapError(
            Finding(Fault::NoPlaces, surface_.name())
                .of(std::count(lost.begin(), lost.end(), 1), surface_.outgoing(v)[0] / 3));
      }
      // Some kernel is empty up to rounding: the faces there are slivers. Without these vertices
      // again, faces get better shapes at the cost of their areas, which come home afterwards.
      for (auto h = halfEdges.rbegin(); h != halfEdges.rend(); ++h) mesh_->collapse(*h);
      improve({1, std::pow(schedule.shapeGain, attempt - 1)}, schedule.coarseSteps);
    }
  }

  /// No two of these vertices are neighbours, so each sees only vertices that do not move. lost:
  /// which found no place.
  void placeAll(const std::vector<int>& back, std::vector<char>& lost) {
    const AreaEnergyWeights weights = weightsAt(mesh_->vertexCount());
    lost.assign(back.size(), 0);
    pool_.forRanges(static_cast<int>(back.size()), [&](int begin, int end) {
      VertexStar star;
      for (int i = begin; i < end; ++i) {
        const int v = back[i];
        gather(v, star);
        Vector3 x;
        // It went to the first of its ring: undo() puts that one first.
        if (!placeInKernel(star.rim, star.rim[0], Admissible::minSolidAngle, x)) {
          lost[i] = 1;
          continue;
        }
        relaxVertex(star, weights, schedule.stepsOfNewVertex, x);
        positions_.row(v) = x.transpose();
      }
    });
  }

  void sweep(const std::vector<int>& vertices, const AreaEnergyWeights& weights) {
    VertexStar star;
    for (int v : vertices) {
      gather(v, star);
      Vector3 x = positions_.row(v).transpose();
      relaxVertex(star, weights, 1, x);
      positions_.row(v) = x.transpose();
    }
  }

  /// Moves all vertices that are there, in at most so many global steps.
  void improve(const AreaEnergyWeights& weights, int steps) {
    std::vector<int> vertices, faceOf;
    FaceRings rings = mesh_->rings(vertices, faceOf);
    const auto n = static_cast<int>(vertices.size());
    AreaStepParameters step;
    step.weights = weights;
    std::vector<FaceTarget> targets(faceOf.size());
    const double mean = 4 * pi / static_cast<double>(faceOf.size());
    pool_.forRanges(static_cast<int>(targets.size()), [&](int begin, int end) {
      for (int f = begin; f < end; ++f) {
        const int h = 3 * faceOf[f];
        targets[f] = {
            4 * pi * mesh_->area(h) / totalArea_, mean,
            faceStiffness({mesh_->point(mesh_->origin(h)), mesh_->point(mesh_->origin(h + 1)),
                           mesh_->point(mesh_->origin(h + 2))},
                          schedule.coarseTrust)};
      }
    });
    AreaMinimiser minimiser(std::move(rings), std::move(targets), &pool_);
    Points positions(n, 3);
    const auto take = [&] {
      for (int i = 0; i < n; ++i) positions.row(i) = positions_.row(vertices[i]);
    };
    take();
    double energy = minimiser.energy(step.weights, positions);
    for (int i = 0; i < steps; ++i) {
      const double before = energy;
      if (n < schedule.coarse) {
        sweep(vertices, step.weights);
        take();
        energy = minimiser.energy(step.weights, positions);
      }
      energy *= minimiser.step(step, positions);
      for (int j = 0; j < n; ++j) positions_.row(vertices[j]) = positions.row(j);
      if (energy > schedule.levelEnd * before) break;
    }
    ++result_.levels;
  }

  void finish(const Progress& progress) {
    std::vector<int> vertices, faceOf;
    FaceRings rings = mesh_->rings(vertices, faceOf);
    std::vector<FaceTarget> targets = faceTargets(mesh_->points(), rings.faces);
    const bool isLarge = mesh_->allVertices() > schedule.large;
    AreaSchedule stages{schedule.firstShape * weightsAt(mesh_->allVertices()).shape,
                        schedule.onTheWay, isLarge ? schedule.atTheEndOfLarge : schedule.atTheEnd,
                        isLarge ? schedule.iterationsOfLarge : schedule.iterations};
    if (final_.area == 0 || (final_.shape > stages.firstShape && !isLarge))
      stages.atTheEnd = schedule.atTheEndOfShapes;
    mesh_.reset();
    AreaMinimiser minimiser(std::move(rings), std::move(targets), &pool_);
    result_.steps = minimiseInStages(minimiser, final_, positions_,
                                     part(progress, 0, schedule.minimised), stages);
    bringHome(minimiser, part(progress, schedule.minimised, 1));
    ++result_.levels;
    turnToSurface();
  }

  /// Where limbs are long, a few faces that span far too much may hold up the rest: then as from
  /// any other start.
  void bringHome(AreaMinimiser& minimiser, const Progress& progress) {
    const double whole = 4 * pi;
    for (int i = 0; i < schedule.rounds && final_.area > 0; ++i) {
      // Shapes that count as much as areas keep these from home, too.
      const double good = i == 0 ? schedule.good : schedule.goodAgain;
      if (minimiser.energy({1, 0}, positions_) < whole * std::max(good, final_.shape)) return;
      Points moved = positions_;
      const int steps = minimiseInStages(
          minimiser, final_, moved,
          part(progress, static_cast<double>(i) / schedule.rounds, (i + 1.0) / schedule.rounds));
      const double before = minimiser.energy(final_, positions_),
                   after = minimiser.energy(final_, moved);
      if (after >= before) return;
      positions_.swap(moved);
      result_.steps += steps;
      if (after > schedule.roundsEnd * before) return;
    }
  }

  /// Back in the surface's order, and turned as the surface is.
  void turnToSurface() {
    Eigen::VectorXd areas = vertexAreas(surface_.vertices(), surface_.faces());
    areas /= areas.sum();
    const double extent =
        (surface_.vertices().colwise().maxCoeff() - surface_.vertices().colwise().minCoeff())
            .maxCoeff();
    Vector3 centre = Vector3::Zero();
    for (int v = 0; v < surface_.vertexCount(); ++v) centre += areas[v] * surface_.vertex(v);
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    result_.positions.resize(surface_.vertexCount(), 3);
    for (int i = 0; i < surface_.vertexCount(); ++i) {
      const int v = order_[i];
      result_.positions.row(v) = positions_.row(i);
      covariance += areas[v] * (surface_.vertex(v) - centre) / extent * positions_.row(i);
    }
    result_.positions *= bestRotation(covariance).transpose();
    result_.positions.rowwise().normalize();
  }

  const ClosedSurface& surface_;
  AreaEnergyWeights final_;
  ThreadPool& pool_;
  std::vector<int> order_;
  std::optional<CollapsibleMesh> mesh_;
  double totalArea_ = 0;
  Points positions_;  // in the mesh's order
  HierarchicalResult result_;
};

}  // namespace

HierarchicalResult hierarchicalMap(const ClosedSurface& surface, const AreaEnergyWeights& weights,
                                   ThreadPool& pool, const Progress& progress) {
  return Refinement(surface, weights, pool).run(progress);
}

}  // namespace sphere_propagation
