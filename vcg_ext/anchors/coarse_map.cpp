// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/anchors/coarse_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "vcg_ext/area/local_step.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/hierarchy/spatial_order.h"
#include "vcg_ext/sphere/admissible.h"
#include "vcg_ext/sphere/kernel_placement.h"
#include "vcg_ext/sphere/spherical_triangle.h"

namespace sphere_propagation {
namespace {

/// Of faces that collapses leave; of an equilateral one it is 0.87.
constexpr double leastFatness = 0.15;
constexpr double longestEdge = 0.4;  // a flow is to be seen
constexpr double asIfFlat = 1e-3;    // a face that is longer is this much less fat
constexpr int mostNeighbours = 12;   // of a vertex that goes
/// A vertex that comes back leaves each face around it this share of the least that one of them
/// had.
constexpr double room = 0.02;
/// Where it finds its place in the kernel: steps from there, and how shapes count beside areas.
constexpr int localSteps = 3;
constexpr AreaEnergyWeights localWeights{1, 3};

/// Twice the area over the longest edge squared; negative where the face is flipped.
double fatness(const Vector3& a, const Vector3& b, const Vector3& c) {
  const double twice = (b - a).cross(c - a).dot(a + b + c) / 3,
               longest =
                   std::max({(a - b).squaredNorm(), (b - c).squaredNorm(), (c - a).squaredNorm()});
  return (longest > longestEdge * longestEdge ? asIfFlat : 1) * twice / longest;
}

size_t following(size_t i, size_t count) { return i + 1 == count ? 0 : i + 1; }

/// Where x lies among the vertices around it (rim, counter-clockwise, on the sphere): a weight for
/// each, by the tangents of half the angles between neighbours, (|a| |b| - a.b) / (a x b).
std::vector<double> meanValueWeights(const Vector3& x, const std::vector<Vector3>& rim) {
  const size_t count = rim.size();
  std::vector<Vector3> edges(count);
  std::vector<double> lengths(count), weights(count, 0);
  for (size_t i = 0; i < count; ++i) {
    edges[i] = rim[i] - x.dot(rim[i]) * x;
    lengths[i] = edges[i].norm();
  }
  for (size_t i = 0; i < count; ++i) {
    const size_t j = following(i, count);
    const double tangent =
        (lengths[i] * lengths[j] - edges[i].dot(edges[j])) / x.dot(edges[i].cross(edges[j]));
    weights[i] += tangent / lengths[i];
    weights[j] += tangent / lengths[j];
  }
  return weights;
}

}  // namespace

CoarseMap::CoarseMap(const MappedSurface& map, const std::vector<char>& kept, int vertices)
    : given_(map),
      order_(spatialOrder(map.surface().vertices())),
      mesh_(map.surface(), order_),
      before_(map.vertexCount(), 3),
      positions_(map.vertexCount(), 3) {
  kept_.reserve(order_.size());
  for (size_t i = 0; i < order_.size(); ++i) {
    before_.row(static_cast<Eigen::Index>(i)) = map.positions().row(order_[i]);
    kept_.push_back(kept[static_cast<size_t>(order_[i])]);
  }
  coarsen(vertices);
  std::vector<int> faceOf;
  rings_ = mesh_.rings(left_, faceOf);
}

/// In rounds, in each of which no two that go are neighbours.
void CoarseMap::coarsen(int vertices) {
  std::vector<int> there(order_.size());
  std::iota(there.begin(), there.end(), 0);
  std::vector<char> busy;
  while (mesh_.vertexCount() > vertices) {
    busy.assign(order_.size(), 0);
    int taken = 0;
    for (const int v : there) {
      if (mesh_.vertexCount() <= vertices) break;
      if (busy[static_cast<size_t>(v)] != 0 || kept_[static_cast<size_t>(v)] != 0) continue;
      const int h = bestCollapse(v);
      if (h < 0) continue;
      int g = h;
      do {
        busy[static_cast<size_t>(mesh_.target(g))] = 1;
        g = mesh_.turned(g);
      } while (g != h);
      mesh_.collapse(h);
      ++taken;
    }
    if (taken == 0) return;
    rounds_.push_back(taken);
    there.erase(
        std::remove_if(there.begin(), there.end(), [&](int v) { return !mesh_.isThere(v); }),
        there.end());
  }
}

/// The collapse of v that leaves the fattest faces; -1 where they would not be fat enough, nor as
/// fat as those that are there.
int CoarseMap::bestCollapse(int v) {
  if (mesh_.degree(v) > mostNeighbours) return -1;
  std::array<int, mostNeighbours> halfEdges{};
  rim_.clear();
  const int first = mesh_.someHalfEdge(v);
  int h = first;
  do {
    halfEdges[rim_.size()] = h;
    rim_.emplace_back(before_.row(mesh_.target(h)).transpose());
    h = mesh_.turned(h);
  } while (h != first);
  const size_t count = rim_.size();
  const Vector3 x = before_.row(v).transpose();
  double enough = leastFatness;
  for (size_t i = 0; i < count; ++i)
    enough = std::min(enough, fatness(x, rim_[i], rim_[following(i, count)]));
  int best = -1;
  for (size_t i = 0; i < count; ++i) {
    double least = 1;
    size_t a = following(i, count), b = following(a, count);
    for (; b != i && least > 0 && least >= enough; a = b, b = following(b, count))
      least = std::min(least, fatness(rim_[i], rim_[a], rim_[b]));
    if (!(least > 0 && least >= enough) || !mesh_.canCollapse(halfEdges[i])) continue;
    best = halfEdges[i];
    enough = least;
  }
  return best;
}

MappedSurface CoarseMap::map() const {
  const auto count = static_cast<Eigen::Index>(left_.size());
  Points vertices(count, 3), positions(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const int v = left_[static_cast<size_t>(i)];
    vertices.row(i) = given_.surface().vertices().row(order_[static_cast<size_t>(v)]);
    positions.row(i) = before_.row(v);
  }
  return MappedSurface(ClosedSurface(std::move(vertices), rings_.faces, given_.surface().name()),
                       std::move(positions));
}

SurfacePoint CoarseMap::onCoarse(const SurfacePoint& point) const {
  std::array<int, 3> corners{};
  for (size_t k = 0; k < 3; ++k) {
    const auto here = std::find(order_.begin(), order_.end(),
                                given_.faces()(point.face, static_cast<Eigen::Index>(k)));
    corners[k] = static_cast<int>(
        std::lower_bound(left_.begin(), left_.end(), static_cast<int>(here - order_.begin())) -
        left_.begin());
  }
  SurfacePoint coarse = point;
  for (int i = rings_.offset[static_cast<size_t>(corners[0])];
       i < rings_.offset[static_cast<size_t>(corners[0]) + 1]; ++i) {
    const int c = rings_.corner[static_cast<size_t>(i)];
    if (rings_.second(c) != corners[1]) continue;
    coarse.face = c / 3;
    for (int k = 0; k < 3; ++k) coarse.weights[(c + k) % 3] = point.weights[k];
  }
  return coarse;
}

MappedSurface CoarseMap::refined(const Points& positions, double ratio,
                                 const std::function<void(Stage&)>& improve) {
  for (size_t i = 0; i < left_.size(); ++i)
    positions_.row(left_[i]) = positions.row(static_cast<Eigen::Index>(i));
  double next = ratio * mesh_.vertexCount();
  for (auto round = rounds_.rbegin(); round != rounds_.rend(); ++round) {
    for (int i = 0; i < *round; ++i) bringBack(mesh_.undo());
    if (mesh_.vertexCount() < next || mesh_.vertexCount() == mesh_.allVertices()) continue;
    improveStage(improve);
    next = ratio * mesh_.vertexCount();
  }
  Points result(positions_.rows(), 3);
  for (size_t i = 0; i < order_.size(); ++i)
    result.row(order_[i]) = positions_.row(static_cast<Eigen::Index>(i));
  return MappedSurface(given_.surface(), std::move(result));
}

void CoarseMap::bringBack(int v) {
  rimBefore_.clear();
  rim_.clear();
  const int first = mesh_.someHalfEdge(v);
  int h = first;
  do {
    rimBefore_.emplace_back(before_.row(mesh_.target(h)).transpose());
    rim_.emplace_back(positions_.row(mesh_.target(h)).transpose());
    h = mesh_.turned(h);
  } while (h != first);
  const Vector3 before = before_.row(v).transpose();
  const std::vector<double> weights = meanValueWeights(before, rimBefore_);
  const size_t count = rim_.size();
  Vector3 x = Vector3::Zero();
  for (size_t i = 0; i < count; ++i) x += weights[i] * rim_[i];
  x.normalize();
  const double least =
      std::max(room * minSolidAngle(rimBefore_, before), Admissible::minSolidAngle);
  if (!x.allFinite() || !(minSolidAngle(rim_, x) >= least)) {
    if (!placeInKernel(rim_, rim_[0], Admissible::minSolidAngle, x))
      throw MapError(Finding(Fault::NoPlaces, given_.surface().name())
                         .of(1, given_.surface().outgoing(order_[static_cast<size_t>(v)])[0] / 3));
    VertexStar star;
    star.rim = rim_;
    double sum = 0;
    for (size_t i = 0; i < count; ++i)
      sum += solidAngle(before, rimBefore_[i], rimBefore_[following(i, count)]);
    for (size_t i = 0; i < count; ++i) {
      const Vector3 &a = rimBefore_[i], &b = rimBefore_[following(i, count)];
      star.targets.emplace_back(solidAngle(before, a, b), sum / static_cast<double>(count),
                                faceStiffness({before, a, b}, {}));
    }
    relaxVertex(star, localWeights, localSteps, x);
  }
  positions_.row(v) = x.transpose();
}

void CoarseMap::improveStage(const std::function<void(Stage&)>& improve) {
  std::vector<int> vertices, faceOf;
  Stage stage;
  stage.rings = mesh_.rings(vertices, faceOf);
  const auto count = static_cast<Eigen::Index>(vertices.size());
  for (Points* points : {&stage.vertices, &stage.before, &stage.positions})
    points->resize(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const int v = vertices[static_cast<size_t>(i)];
    stage.vertices.row(i) = mesh_.points().row(v);
    stage.before.row(i) = before_.row(v);
    stage.positions.row(i) = positions_.row(v);
    stage.kept.push_back(kept_[static_cast<size_t>(v)]);
  }
  improve(stage);
  for (Eigen::Index i = 0; i < count; ++i)
    positions_.row(vertices[static_cast<size_t>(i)]) = stage.positions.row(i);
}

}  // namespace sphere_propagation
