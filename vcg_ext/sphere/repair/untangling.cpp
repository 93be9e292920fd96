// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/repair/untangling.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "vcg_ext/base/linear_solvers.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/sphere/certificate.h"
#include "vcg_ext/sphere/repair/nearby_map.h"
#include "vcg_ext/sphere/spherical_triangle.h"

namespace sphere_propagation {
namespace {

/// A little above what the certificate asks, so that what is good here is good there.
constexpr double minSolidAngle = 10 * Certificate::minSolidAngle;
/// Shorter edges pull no harder than this share of the mean edge: a vertex must not be glued to its
/// neighbour.
constexpr double shortestEdge = 0.05;
// Of a larger patch, what lies around it says less than its own positions do: on noisy walls and
// folded tips 12 rings moved a sixth of all landmarks by 10 mm (docs/propagation_robust.md).
constexpr int ringsOfALocalRepair = 5;

bool isFlipped(const ClosedSurface& surface, const Points& positions, int f) {
  const auto at = [&](int k) { return Vector3(positions.row(surface.faces()(f, k)).transpose()); };
  return !(solidAngle(at(0), at(1), at(2)) >= minSolidAngle);  // true for NaN
}

/// The flipped faces, and what lies around them. Keeps its marks from round to round, so that a
/// round costs what it frees and not what the mesh has.
class FlippedRegion {
 public:
  FlippedRegion(const ClosedSurface& surface, const Points& positions,
                const std::vector<char>& held)
      : surface_(surface),
        positions_(positions),
        held_(held),
        index_(static_cast<size_t>(surface.vertexCount()), -1) {
    for (int f = 0; f < surface.faceCount(); ++f)
      if (isFlipped(surface, positions, f)) flipped_.push_back(f);
  }

  /// Frees the vertices of flipped faces and of `rings` rings around them, fewer where some vertex
  /// would not stay. False where even without a ring none stays, and where all are held.
  bool free(int rings) {
    for (int v : free_) index_[v] = -1;
    free_.clear();
    rings_ = 0;
    const auto all = static_cast<size_t>(surface_.vertexCount());
    const auto add = [&](int v) {
      if (index_[v] >= 0 || (!held_.empty() && held_[v] != 0)) return;
      index_[v] = 0;
      free_.push_back(v);
    };
    for (int f : flipped_)
      for (int k = 0; k < 3; ++k) add(surface_.faces()(f, k));
    if (free_.empty() || free_.size() == all) return false;
    for (size_t begin = 0; rings_ < rings; ++rings_) {
      const size_t end = free_.size();
      for (size_t i = begin; i < end; ++i)
        for (int w : surface_.ring(free_[i])) add(w);
      begin = end;
      if (free_.size() < all) continue;
      for (size_t i = end; i < all; ++i) index_[free_[i]] = -1;
      free_.resize(end);
      break;
    }
    std::sort(free_.begin(), free_.end());
    for (size_t i = 0; i < free_.size(); ++i) index_[free_[i]] = static_cast<int>(i);
    return true;
  }

  /// After free vertices moved: only faces at these can have changed.
  void lookAgain() {
    flipped_.clear();
    for (int v : free_)
      for (int h : surface_.outgoing(v)) {
        const int f = h / 3;
        // Once, at its first free vertex.
        bool first = true;
        for (int k = 0; k < 3; ++k) {
          const int w = surface_.faces()(f, k);
          first = first && (index_[w] < 0 || index_[w] >= index_[v]);
        }
        if (first && isFlipped(surface_, positions_, f)) flipped_.push_back(f);
      }
  }

  bool empty() const { return flipped_.empty(); }
  const std::vector<int>& freeVertices() const { return free_; }  ///< ascending
  int rings() const { return rings_; }                            ///< that were freed
  /// The place of a vertex among those that are free; -1 where it is not.
  int index(int v) const { return index_[v]; }

 private:
  const ClosedSurface& surface_;
  const Points& positions_;
  const std::vector<char>& held_;
  std::vector<int> index_, free_, flipped_;
  int rings_ = 0;
};

/// Tutte's system: every free vertex at the weighted mean of its neighbours, the others fixed; then
/// back on the sphere.
void solveFreeVertices(const ClosedSurface& surface, const FlippedRegion& region, double shortest,
                       Points& positions) {
  const std::vector<int>& vertex = region.freeVertices();
  const auto count = static_cast<Eigen::Index>(vertex.size());
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixX3d right = Eigen::MatrixX3d::Zero(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const int v = vertex[static_cast<size_t>(i)];
    double sum = 0;
    for (int w : surface.ring(v)) {
      const double weight = 1 / std::max((surface.vertex(v) - surface.vertex(w)).norm(), shortest);
      sum += weight;
      if (region.index(w) >= 0)
        entries.emplace_back(i, region.index(w), -weight);
      else
        right.row(i) += weight * positions.row(w);
    }
    entries.emplace_back(i, i, sum);
  }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  SparseCholesky solver;
  solver.compute(matrix);
  if (!solver.succeeded()) return;
  const Eigen::MatrixX3d solution = solver.solve(right);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double length = solution.row(i).norm();
    if (length > 1e-12) positions.row(vertex[static_cast<size_t>(i)]) = solution.row(i) / length;
  }
}

/// The rings of the next round, at most maxRings: one more of a few, half as many again of many.
int grown(int rings, int maxRings) {
  constexpr int few = 3;
  const int more = rings < few ? 1 : (rings + 1) / 2;
  return more < maxRings - rings ? rings + more : maxRings;
}

void normalise(Points& positions) {
  for (auto x : positions.rowwise()) {
    const double length = x.norm();
    if (length > 0 && std::isfinite(length)) x /= length;
  }
}

int countMoved(const Points& before, const Points& after) {
  int moved = 0;
  for (Eigen::Index v = 0; v < before.rows(); ++v) moved += before.row(v) != after.row(v);
  return moved;
}

}  // namespace

Untangled untangle(const ClosedSurface& surface, Points positions, int maxRings,
                   const Progress& progress, const std::vector<char>& held) {
  normalise(positions);
  const Certificate before = certify(surface.faces(), positions);
  const Points original = positions;
  const double shortest = shortestEdge * meanEdgeLength(surface.vertices(), surface.faces());
  // Each round looks afresh which faces are flipped, so what an earlier, smaller ring mended stays
  // as it is.
  FlippedRegion region(surface, positions, held);
  bool last = maxRings < 1;
  double share = 0;
  for (int rings = 1; !region.empty(); rings = grown(rings, maxRings)) {
    if (last || !region.free(rings)) {
      const Certificate now = certify(surface.faces(), positions);
      throw MapError(Finding(Fault::NotRepairable, surface.name())
                         .of(now.flippedFaces, now.firstFlippedFace)
                         .amid(before.flippedFaces));
    }
    const auto free = static_cast<double>(region.freeVertices().size());
    report(progress, share = std::max(share, free / surface.vertexCount()));
    solveFreeVertices(surface, region, shortest, positions);
    region.lookAgain();
    last = rings == maxRings || region.rings() < rings;
  }
  const int moved = countMoved(original, positions);
  return {MappedSurface(surface, std::move(positions)), static_cast<int>(before.flippedFaces),
          moved};
}

Untangled mend(const ClosedSurface& surface, Points positions, const Progress& progress) {
  normalise(positions);
  try {
    return untangle(surface, positions, ringsOfALocalRepair, progress);
  } catch (const MapError&) {
    MappedSurface map = nearbyMap(surface, positions);
    const int moved = countMoved(positions, map.positions());
    return {std::move(map), static_cast<int>(certify(surface.faces(), positions).flippedFaces),
            moved};
  }
}

}  // namespace sphere_propagation
