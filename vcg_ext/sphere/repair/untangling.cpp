// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/repair/untangling.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

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
constexpr int ringsOfALocalRepair = 12;

bool isFlipped(const ClosedSurface& surface, const Points& positions, int f) {
  const auto at = [&](int k) { return Vector3(positions.row(surface.faces()(f, k)).transpose()); };
  return !(solidAngle(at(0), at(1), at(2)) >= minSolidAngle);  // true for NaN
}

/// The vertices of flipped faces and of `rings` rings around them.
std::vector<char> verticesToFree(const ClosedSurface& surface, const Points& positions, int rings) {
  std::vector<char> free(static_cast<size_t>(surface.vertexCount()), 0);
  std::vector<int> front, next;
  const auto add = [&](int v, std::vector<int>& to) {
    if (free[v]) return;
    free[v] = 1;
    to.push_back(v);
  };
  for (int f = 0; f < surface.faceCount(); ++f)
    if (isFlipped(surface, positions, f))
      for (int k = 0; k < 3; ++k) add(surface.faces()(f, k), front);
  for (int ring = 0; ring < rings; ++ring) {
    next.clear();
    for (int v : front)
      for (int w : surface.ring(v)) add(w, next);
    front.swap(next);
  }
  return free;
}

/// Tutte's system: every free vertex at the weighted mean of its neighbours, the others fixed; then
/// back on the sphere.
void solveFreeVertices(const ClosedSurface& surface, const std::vector<char>& free, double shortest,
                       Points& positions) {
  std::vector<int> index(free.size(), -1), vertex;
  for (int v = 0; v < surface.vertexCount(); ++v)
    if (free[v]) {
      index[v] = static_cast<int>(vertex.size());
      vertex.push_back(v);
    }
  const auto count = static_cast<Eigen::Index>(vertex.size());
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixX3d right = Eigen::MatrixX3d::Zero(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const int v = vertex[static_cast<size_t>(i)];
    double sum = 0;
    for (int w : surface.ring(v)) {
      const double weight = 1 / std::max((surface.vertex(v) - surface.vertex(w)).norm(), shortest);
      sum += weight;
      if (free[w])
        entries.emplace_back(i, index[w], -weight);
      else
        right.row(i) += weight * positions.row(w);
    }
    entries.emplace_back(i, i, sum);
  }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
  if (solver.info() != Eigen::Success) return;
  const Eigen::MatrixX3d solution = solver.solve(right);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double length = solution.row(i).norm();
    if (length > 1e-12) positions.row(vertex[static_cast<size_t>(i)]) = solution.row(i) / length;
  }
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

Untangled untangle(const ClosedSurface& surface, Points positions, int maxRings) {
  normalise(positions);
  const Certificate before = certify(surface.faces(), positions);
  const Points original = positions;
  const double shortest = shortestEdge * meanEdgeLength(surface.vertices(), surface.faces());
  // Each round looks afresh which faces are flipped, so what an earlier, smaller ring mended stays
  // as it is.
  for (int rings = 1;; ++rings) {
    const std::vector<char> free = verticesToFree(surface, positions, rings);
    const auto freed = std::count(free.begin(), free.end(), 1);
    if (freed == 0) break;
    if (freed == surface.vertexCount() || rings > maxRings) {
      const Certificate now = certify(surface.faces(), positions);
      throw MapError(
          now.flippedFaces, now.firstFlippedFace,
          "Layer \"" + surface.name() +
              "\": its positions on the sphere cannot be made a valid map by local repair: " +
              std::to_string(before.flippedFaces) + " faces were flipped, " +
              std::to_string(now.flippedFaces) + " still are, the first is face " +
              std::to_string(now.firstFlippedFace) + ".");
    }
    solveFreeVertices(surface, free, shortest, positions);
  }
  const int moved = countMoved(original, positions);
  return {MappedSurface(surface, std::move(positions)), static_cast<int>(before.flippedFaces), moved};
}

Untangled mend(const ClosedSurface& surface, Points positions) {
  normalise(positions);
  try {
    return untangle(surface, positions, ringsOfALocalRepair);
  } catch (const MapError&) {
    MappedSurface map = nearbyMap(surface, positions);
    const int moved = countMoved(positions, map.positions());
    return {std::move(map), static_cast<int>(certify(surface.faces(), positions).flippedFaces),
            moved};
  }
}

}  // namespace sphere_propagation
