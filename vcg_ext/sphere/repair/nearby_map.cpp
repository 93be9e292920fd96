// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/repair/nearby_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/rotation.h"
#include "vcg_ext/mesh/hierarchy/collapsible_mesh.h"
#include "vcg_ext/mesh/hierarchy/simplification.h"
#include "vcg_ext/mesh/hierarchy/spatial_order.h"
#include "vcg_ext/sphere/admissible.h"
#include "vcg_ext/sphere/kernel_placement.h"
#include "vcg_ext/sphere/spherical_triangle.h"

namespace sphere_propagation {
namespace {

/// Where positions crowd so that a vertex finds no room, those around it are given up, and all is
/// laid again.
constexpr int maxAttempts = 20;
constexpr int sweeps = 8, lastSweeps = 40, easedRings = 2;
/// On the way to its position a vertex leaves the faces around it this share of the mean solid
/// angle, or what they have.
constexpr double roomOnTheWay = 1e-3;

class Refinement {
 public:
  Refinement(const ClosedSurface& surface, const Points& targets)
      : surface_(surface),
        order_(spatialOrder(surface.vertices())),
        mesh_(surface, order_),
        targets_(surface.vertexCount(), 3),
        positions_(surface.vertexCount(), 3) {
    for (size_t i = 0; i < order_.size(); ++i)
      targets_.row(static_cast<Eigen::Index>(i)) = targets.row(order_[i]);
  }

  /// Empty where there is no room for a vertex: crowd() is why.
  std::optional<MappedSurface> run() {
    ThreadPool pool;
    const std::vector<int> rounds = simplify(mesh_, pool);
    layTetrahedron();
    int next = 8;
    for (auto round = rounds.rbegin(); round != rounds.rend(); ++round) {
      for (int i = 0; i < *round; ++i)
        if (!place(mesh_.undo())) return std::nullopt;
      if (mesh_.vertexCount() < next || mesh_.vertexCount() == mesh_.allVertices()) continue;
      attract(sweeps);
      next = 2 * mesh_.vertexCount();
    }
    attract(lastSweeps);
    ease();
    Points result(positions_.rows(), 3);
    for (size_t i = 0; i < order_.size(); ++i)
      result.row(order_[i]) = positions_.row(static_cast<Eigen::Index>(i));
    return MappedSurface(surface_, std::move(result));
  }

  /// The vertex that found no room, and those around it then, up to the second ring.
  const std::vector<int>& crowd() const { return crowd_; }

 private:
  Vector3 target(int v) const { return targets_.row(v).transpose(); }
  Vector3 position(int v) const { return positions_.row(v).transpose(); }
  bool asksForAPlace(int v) const { return std::fabs(targets_.row(v).squaredNorm() - 1) < 1e-6; }

  void layTetrahedron() {
    const std::array<int, 4> corners = mesh_.tetrahedron();
    bool good = true;
    for (int v : corners) {
      positions_.row(v) = targets_.row(v);
      good = good && asksForAPlace(v);
    }
    for (size_t i = 0; good && i < corners.size(); ++i) {
      gather(corners[i]);
      good = fits(position(corners[i]), Admissible::minSolidAngle);
    }
    if (good) return;
    const Eigen::Matrix<double, 4, 3> regular = regularTetrahedron();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (int i = 0; i < 4; ++i)
      if (asksForAPlace(corners[i])) covariance += target(corners[i]) * regular.row(i);
    const Eigen::Matrix3d rotation = bestRotation(covariance);
    for (int i = 0; i < 4; ++i) positions_.row(corners[i]) = regular.row(i) * rotation.transpose();
  }

  template <class Function>
  void forRing(int v, const Function& act) const {
    const int first = mesh_.someHalfEdge(v);
    int h = first;
    do {
      act(mesh_.target(h));
      h = mesh_.turned(h);
    } while (h != first);
  }

  void gather(int v) {
    rim_.clear();
    forRing(v, [&](int w) { rim_.push_back(position(w)); });
  }

  bool fits(const Vector3& x, double least) const { return minSolidAngle(rim_, x) >= least; }

  /// To its position if it fits there, else towards `goal` as far as there is room. From a place
  /// that is good.
  Vector3 moved(const Vector3& from, const Vector3& goal) const {
    const double mean = 4 * pi / (2 * mesh_.vertexCount() - 4);
    const double least = std::max(std::min(roomOnTheWay * mean, minSolidAngle(rim_, from)),
                                  Admissible::minSolidAngle);
    for (double share = 1; share > 0.1; share /= 2) {
      const Vector3 x = (from + share * (goal - from)).normalized();
      if (x.allFinite() && fits(x, least)) return x;
    }
    return from;
  }

  bool place(int v) {
    gather(v);
    if (asksForAPlace(v) && fits(target(v), Admissible::minSolidAngle)) {
      positions_.row(v) = targets_.row(v);
      return true;
    }
    Vector3 x;
    // It left to its someHalfEdge's target; undo() puts that one first.
    if (!placeInKernel(rim_, rim_[0], Admissible::minSolidAngle, x)) {
      crowd_ = {order_[static_cast<size_t>(v)]};
      forRing(v, [&](int w) {
        crowd_.push_back(order_[static_cast<size_t>(w)]);
        forRing(w, [&](int u) { crowd_.push_back(order_[static_cast<size_t>(u)]); });
      });
      return false;
    }
    positions_.row(v) = (asksForAPlace(v) ? moved(x, target(v)) : x).transpose();
    return true;
  }

  /// Vertices that are elsewhere lean on their neighbours, and take their positions once these fit.
  void attract(int most) {
    std::vector<int> elsewhere;
    for (int v = 0; v < mesh_.allVertices(); ++v)
      if (mesh_.isThere(v) && positions_.row(v) != targets_.row(v)) elsewhere.push_back(v);
    for (int sweep = 0; sweep < most && !elsewhere.empty(); ++sweep) {
      size_t left = 0;
      for (int v : elsewhere) {
        gather(v);
        if (asksForAPlace(v) && fits(target(v), Admissible::minSolidAngle)) {
          positions_.row(v) = targets_.row(v);
          continue;
        }
        const Vector3 mean = meanOfRing(v);
        const Vector3 goal =
            asksForAPlace(v) ? Vector3(0.7 * mean + 0.3 * target(v)).normalized() : mean;
        positions_.row(v) = moved(position(v), goal).transpose();
        elsewhere[left++] = v;
      }
      elsewhere.resize(left);
    }
  }

  /// Where vertices were squeezed in, those around them give way: each at the mean of its
  /// neighbours.
  void ease() {
    std::vector<char> free(static_cast<size_t>(mesh_.allVertices()), 0);
    std::vector<int> squeezed;
    const auto add = [&](int v) {
      if (free[static_cast<size_t>(v)]) return;
      free[static_cast<size_t>(v)] = 1;
      squeezed.push_back(v);
    };
    for (int v = 0; v < mesh_.allVertices(); ++v)
      if (positions_.row(v) != targets_.row(v)) add(v);
    for (int ring = 0, from = 0; ring < easedRings; ++ring) {
      const auto to = static_cast<int>(squeezed.size());
      for (int i = from; i < to; ++i) forRing(squeezed[static_cast<size_t>(i)], add);
      from = to;
    }
    for (int sweep = 0; sweep < lastSweeps; ++sweep)
      for (int v : squeezed) {
        gather(v);
        positions_.row(v) = moved(position(v), meanOfRing(v)).transpose();
      }
  }

  /// Weighted as the paper's smoothing is.
  Vector3 meanOfRing(int v) const {
    Vector3 mean = Vector3::Zero();
    size_t i = 0;
    forRing(v, [&](int w) {
      mean += rim_[i++] / std::max((mesh_.point(v) - mesh_.point(w)).norm(), 1e-6);
    });
    return mean.normalized();
  }

  const ClosedSurface& surface_;
  std::vector<int> order_;
  CollapsibleMesh mesh_;
  Points targets_, positions_;
  std::vector<Vector3> rim_;
  std::vector<int> crowd_;
};

}  // namespace

MappedSurface nearbyMap(const ClosedSurface& surface, const Points& positions) {
  Points wishes = positions;
  int first = -1;  // that found no room
  for (int attempt = 0; attempt <= maxAttempts; ++attempt) {
    // In the last one nobody asks for a place.
    if (attempt == maxAttempts) wishes.setZero();
    Refinement refinement(surface, wishes);
    if (std::optional<MappedSurface> map = refinement.run()) return std::move(*map);
    if (first < 0) first = refinement.crowd().front();
    for (int v : refinement.crowd()) wishes.row(v).setZero();
  }
  throw MapError(Finding(Fault::NoRoom, surface.name()).of(1, first));
}

}  // namespace sphere_propagation
