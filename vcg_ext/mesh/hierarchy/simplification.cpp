// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/hierarchy/simplification.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace sphere_propagation {
namespace {

constexpr int maxDegree = 24;  // of a vertex that may go
constexpr int preferredDegree = 8;
constexpr size_t few = 200;  // vertices: the ends of limbs are among those that cost most
constexpr float none = std::numeric_limits<float>::infinity();

/// sum of area times squared distance from planes: p^T A p + 2 b.p + c.
struct Quadric {
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0, bx = 0, by = 0, bz = 0, c = 0;

  void addPlane(const Vector3& n, double d, double weight) {
    xx += weight * n[0] * n[0], yy += weight * n[1] * n[1], zz += weight * n[2] * n[2];
    xy += weight * n[0] * n[1], xz += weight * n[0] * n[2], yz += weight * n[1] * n[2];
    bx += weight * d * n[0], by += weight * d * n[1], bz += weight * d * n[2];
    c += weight * d * d;
  }
  void operator+=(const Quadric& o) {
    xx += o.xx, yy += o.yy, zz += o.zz, xy += o.xy, xz += o.xz, yz += o.yz;
    bx += o.bx, by += o.by, bz += o.bz, c += o.c;
  }
  double at(const Vector3& p) const {
    return p[0] * (xx * p[0] + 2 * (xy * p[1] + xz * p[2] + bx)) +
           p[1] * (yy * p[1] + 2 * (yz * p[2] + by)) + p[2] * (zz * p[2] + 2 * bz) + c;
  }
};

class Simplification {
 public:
  Simplification(CollapsibleMesh& mesh, ThreadPool& pool) : mesh_(mesh), pool_(pool) {
    const auto n = static_cast<size_t>(mesh.allVertices());
    quadric_.resize(n);
    cost_.resize(n);
    best_.resize(n);
    changed_.assign(n, 1);
    busy_.assign(n, 0);
    pool_.forRanges(mesh.allVertices(), [&](int begin, int end) {
      for (int v = begin; v < end; ++v) quadric_[v] = quadricOf(v);
    });
  }

  /// One round; returns how many vertices it took.
  int takeRound(std::vector<int>& there) {
    pool_.forRanges(static_cast<int>(there.size()), [&](int begin, int end) {
      for (int i = begin; i < end; ++i)
        if (changed_[there[i]]) findBest(there[i]);
    });
    sorted_.resize(there.size());
    for (size_t i = 0; i < there.size(); ++i) {
      const int v = there[i];
      sorted_[i] = cost_[v];
      changed_[v] = busy_[v] = 0;
    }
    const auto limit = sorted_.begin() +
                       static_cast<std::ptrdiff_t>(sorted_.size() / (there.size() < few ? 4 : 2));
    std::nth_element(sorted_.begin(), limit, sorted_.end());
    int taken = takeCheaperThan(*limit, there);
    // Everything that costs the same, or what is cheap is in the way of itself: any vertex that can
    // go will do.
    if (taken == 0) taken = takeCheaperThan(none, there);
    there.erase(
        std::remove_if(there.begin(), there.end(), [&](int v) { return !mesh_.isThere(v); }),
        there.end());
    return taken;
  }

 private:
  Quadric quadricOf(int v) const {
    Quadric quadric;
    const int first = mesh_.someHalfEdge(v);
    int h = first;
    do {
      const Vector3 a = mesh_.point(v), b = mesh_.point(mesh_.target(h)),
                    c = mesh_.point(mesh_.target(mesh_.turned(h)));
      const Vector3 n = (b - a).cross(c - a);
      const double length = n.norm();
      if (length > 0) quadric.addPlane(n / length, -n.dot(a) / length, 0.5 * length);
      h = mesh_.turned(h);
    } while (h != first);
    return quadric;
  }

  /// The cheapest collapse that takes v away.
  void findBest(int v) {
    cost_[v] = none;
    best_[v] = -1;
    const int degree = mesh_.degree(v);
    if (degree > maxDegree) return;
    std::array<float, maxDegree> cost{};
    std::array<int, maxDegree> halfEdge{};
    double area = 0;
    int h = mesh_.someHalfEdge(v);
    for (int i = 0; i < degree; ++i, h = mesh_.turned(h)) {
      halfEdge[i] = h;
      area += mesh_.area(h);
    }
    for (int i = 0; i < degree; ++i) {
      const int w = mesh_.target(halfEdge[i]);
      const Vector3 p = mesh_.point(w);
      double c =
          std::max(quadric_[v].at(p), 0.0) + 1e-3 * area * (p - mesh_.point(v)).squaredNorm();
      const double excess = degree + mesh_.degree(w) - 4 - preferredDegree;
      if (excess > 0) c = (c + 1e-30) * (1 + 0.1 * excess * excess);
      cost[i] = static_cast<float>(std::min(c, 1e30));
    }
    for (int tries = 0; tries < degree; ++tries) {
      const auto least = std::min_element(cost.begin(), cost.begin() + degree);
      const int i = static_cast<int>(least - cost.begin());
      if (mesh_.canCollapse(halfEdge[i])) {
        cost_[v] = *least;
        best_[v] = halfEdge[i];
        return;
      }
      cost[i] = none;
    }
  }

  int takeCheaperThan(float limit, const std::vector<int>& there) {
    int taken = 0;
    for (int v : there) {
      if (busy_[v] || !(cost_[v] <= limit) || best_[v] < 0 || mesh_.vertexCount() <= 4) continue;
      if (!mesh_.canCollapse(best_[v])) {  // no longer: an edge has come
        findBest(v);
        if (best_[v] < 0 || cost_[v] > limit) continue;
      }
      const int h = best_[v], w = mesh_.target(h), degree = mesh_.degree(v);
      int g = h;
      for (int i = 0; i < degree; ++i, g = mesh_.turned(g))
        busy_[mesh_.target(g)] = changed_[mesh_.target(g)] = 1;
      mesh_.collapse(h);
      quadric_[w] += quadric_[v];
      ++taken;
    }
    return taken;
  }

  CollapsibleMesh& mesh_;
  ThreadPool& pool_;
  std::vector<Quadric> quadric_;
  std::vector<float> cost_, sorted_;
  std::vector<int> best_;
  std::vector<char> changed_, busy_;
};

}  // namespace

std::vector<int> simplify(CollapsibleMesh& mesh, ThreadPool& pool, const Progress& progress) {
  Simplification simplification(mesh, pool);
  std::vector<int> there(static_cast<size_t>(mesh.allVertices())), rounds;
  for (int v = 0; v < mesh.allVertices(); ++v) there[v] = v;
  while (mesh.vertexCount() > 4) {
    rounds.push_back(simplification.takeRound(there));
    report(progress, 1 - static_cast<double>(mesh.vertexCount()) / mesh.allVertices());
  }
  return rounds;
}

}  // namespace sphere_propagation
