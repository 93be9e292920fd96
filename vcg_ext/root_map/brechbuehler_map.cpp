// SPDX-License-Identifier: GPL-3.0-only
// C. Brechbuehler, G. Gerig, O. Kuebler, Parametrization of closed surfaces for 3-D shape
// description, 1995.

#include "vcg_ext/root_map/brechbuehler_map.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include "vcg_ext/base/linear_solvers.h"

namespace sphere_propagation {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;

void checkPoles(const ClosedSurface& surface, const Poles& poles) {
  const auto inside = [&](int v) { return v >= 0 && v < surface.vertexCount(); };
  if (!inside(poles.north) || !inside(poles.south) || poles.north == poles.south)
    throw ArgumentError("Surface \"" + surface.name() +
                        "\": the poles must be two different vertices of its " +
                        std::to_string(surface.vertexCount()) + ", but they are " +
                        std::to_string(poles.north) + " and " + std::to_string(poles.south) + ".");
}

/// The index of the pole in the ring of the other, -1 if they are no neighbours.
int positionInRing(const ClosedSurface& surface, int centre, int v) {
  const IndexRange ring = surface.ring(centre);
  for (int i = 0; i < ring.size(); ++i)
    if (ring[i] == v) return i;
  return -1;
}

/// Both systems have the same unknowns (all vertices but the poles) and the same off-diagonal
/// entries, so that the fill-reducing order is found once.
class LaplaceSystem {
 public:
  LaplaceSystem(const ClosedSurface& surface, const Poles& poles)
      : surface_(surface), poles_(poles) {
    checkPoles(surface, poles);
    unknown_.resize(surface.vertexCount());
    int count = 0;
    for (int v = 0; v < surface.vertexCount(); ++v) unknown_[v] = isPole(v) ? -1 : count++;
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(static_cast<size_t>(count) + 3 * static_cast<size_t>(surface.faceCount()));
    for (int v = 0; v < surface.vertexCount(); ++v) {
      if (isPole(v)) continue;
      const IndexRange ring = surface.ring(v);
      entries.emplace_back(unknown_[v], unknown_[v], ring.size());
      for (int w : ring)
        if (!isPole(w)) entries.emplace_back(unknown_[v], unknown_[w], -1.0);
    }
    matrix_.resize(count, count);
    matrix_.setFromTriplets(entries.begin(), entries.end());
    solver_.analysePattern(matrix_);
  }

  Eigen::VectorXd colatitudes() {
    Eigen::VectorXd b = Eigen::VectorXd::Zero(matrix_.rows());
    for (int w : surface_.ring(poles_.south))
      if (!isPole(w)) b[unknown_[w]] += pi;
    solver_.factorise(matrix_);
    Eigen::VectorXd result = spread(solver_.solve(b));
    result[poles_.south] = pi;
    return result;
  }

  Eigen::VectorXd longitudes(const DateLine& line) {
    SparseMatrix matrix = matrix_;
    for (int pole : {poles_.north, poles_.south})
      for (int w : surface_.ring(pole))
        if (!isPole(w)) matrix.coeffRef(unknown_[w], unknown_[w]) -= 1;
    bool samePattern = true;
    if (line.path.size() == 2 &&
        line.crossings.size() == 1) {  // neighbour poles: the edge across theirs
      const int east = unknown_[line.crossings[0][0]], west = unknown_[line.crossings[0][1]];
      const Eigen::Index before = matrix.nonZeros();
      for (const auto& [i, j, value] :
           {std::make_tuple(east, east, 1.0), std::make_tuple(west, west, 1.0),
            std::make_tuple(east, west, -1.0), std::make_tuple(west, east, -1.0)})
        matrix.coeffRef(i, j) += value;
      samePattern = matrix.nonZeros() == before;
      matrix.makeCompressed();
    }
    // Without this the longitudes are known up to a constant only. The right-hand side sums to
    // zero, and so do the columns of the rest: the sum of all equations says that the anchor's
    // longitude is zero.
    const int anchor = line.path.size() > 2 ? unknown_[line.path[1]] : 0;
    matrix.coeffRef(anchor, anchor) += 2;
    Eigen::VectorXd b = Eigen::VectorXd::Zero(matrix.rows());
    for (const auto& [here, west] : line.crossings) {
      b[unknown_[west]] += 2 * pi;
      b[unknown_[here]] -= 2 * pi;
    }
    if (!samePattern) solver_.analysePattern(matrix);
    solver_.factorise(matrix);
    return spread(solver_.solve(b));
  }

 private:
  bool isPole(int v) const { return v == poles_.north || v == poles_.south; }

  /// One value per vertex, 0 at the poles.
  Eigen::VectorXd spread(const Eigen::VectorXd& solution) const {
    Eigen::VectorXd result = Eigen::VectorXd::Zero(surface_.vertexCount());
    for (int v = 0; v < surface_.vertexCount(); ++v)
      if (unknown_[v] >= 0) result[v] = solution[unknown_[v]];
    return result;
  }

  const ClosedSurface& surface_;
  Poles poles_;
  std::vector<int> unknown_;  // #V: row of the vertex in the systems, -1 for a pole
  SparseMatrix matrix_;       // of the colatitudes
  SparseCholesky solver_;
};

/// From north to south, each step to the neighbour with the largest colatitude; empty if that ends
/// on a peak.
std::vector<int> steepestPath(const ClosedSurface& surface, const Poles& poles,
                              const Eigen::VectorXd& colatitudes) {
  std::vector<int> path{poles.north};
  while (path.back() != poles.south) {
    const int here = path.back();
    int best = here;
    for (int w : surface.ring(here))
      if (w == poles.south) {
        best = w;
        break;
      } else if (colatitudes[w] > colatitudes[best] ||
                 (colatitudes[w] == colatitudes[best] && best != here && w < best)) {
        best = w;
      }
    // Colatitudes grow from step to step, so no vertex comes twice; the north pole is asked for
    // since they may be anything.
    if (best == here || best == poles.north) return {};
    path.push_back(best);
  }
  return path;
}

std::vector<int> shortestPath(const ClosedSurface& surface, const Poles& poles) {
  std::vector<int> before(surface.vertexCount(), -1), queue{poles.south};
  before[poles.south] = poles.south;
  for (size_t i = 0; before[poles.north] < 0; ++i)
    for (int w : surface.ring(queue[i]))
      if (before[w] < 0) before[w] = queue[i], queue.push_back(w);
  std::vector<int> path{poles.north};
  while (path.back() != poles.south) path.push_back(before[path.back()]);
  return path;
}

Points onSphere(const Eigen::VectorXd& colatitudes, const Eigen::VectorXd& longitudes) {
  Points positions(colatitudes.size(), 3);
  for (Eigen::Index v = 0; v < colatitudes.size(); ++v) {
    const double radius = std::sin(colatitudes[v]);
    positions.row(v) << radius * std::cos(longitudes[v]), radius * std::sin(longitudes[v]),
        std::cos(colatitudes[v]);
  }
  return positions;
}

}  // namespace

Poles extremePoles(const ClosedSurface& surface) {
  const Points& vertices = surface.vertices();
  // Relative to the extent, so that the squares stay within the range of numbers.
  const Vector3 middle = 0.5 * vertices.colwise().minCoeff() + 0.5 * vertices.colwise().maxCoeff();
  const double extent = (vertices.rowwise() - middle.transpose()).cwiseAbs().maxCoeff();
  Points centred = (vertices.rowwise() - middle.transpose()) / extent;
  const Eigen::RowVector3d mean =
      Eigen::RowVectorXd::Constant(centred.rows(), 1.0 / surface.vertexCount()) * centred;
  centred.rowwise() -= mean;
  const Eigen::Matrix3d covariance = centred.transpose() * centred;
  Vector3 axis = eigenOf(covariance).vectors.col(2);
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  if (axis[largest] < 0) axis = -axis;
  Eigen::VectorXd along = centred * axis;
  const double skewness = along.array().cube().sum(), scale = along.array().abs().cube().sum();
  if (skewness < -1e-9 * scale) along = -along;
  const double high = along.maxCoeff(), low = along.minCoeff(), tie = 1e-9 * (high - low);
  const auto first = [&](auto condition) {
    int v = 0;
    while (!condition(along[v])) ++v;
    return v;
  };
  return {first([&](double x) { return x >= high - tie; }),
          first([&](double x) { return x <= low + tie; })};
}

Eigen::VectorXd colatitudes(const ClosedSurface& surface, const Poles& poles) {
  return LaplaceSystem(surface, poles).colatitudes();
}

DateLine dateLine(const ClosedSurface& surface, const Poles& poles,
                  const Eigen::VectorXd& colatitudes) {
  checkPoles(surface, poles);
  DateLine line;
  line.path = steepestPath(surface, poles, colatitudes);
  if (line.path.empty()) line.path = shortestPath(surface, poles);
  if (line.path.size() == 2) {
    const IndexRange ring = surface.ring(poles.north);
    const int i = positionInRing(surface, poles.north, poles.south), n = ring.size();
    line.crossings.push_back({ring[(i + 1) % n], ring[(i + n - 1) % n]});
    return line;
  }
  for (size_t k = 1; k + 1 < line.path.size(); ++k) {
    // The ring is counter-clockwise seen from outside: from the vertex before (north) over the west
    // to the next (south).
    const int here = line.path[k];
    const IndexRange ring = surface.ring(here);
    for (int i = positionInRing(surface, here, line.path[k - 1]) + 1;; ++i) {
      const int w = ring[i % ring.size()];
      if (w == line.path[k + 1]) break;
      if (w != poles.north && w != poles.south) line.crossings.push_back({here, w});
    }
  }
  return line;
}

Eigen::VectorXd longitudes(const ClosedSurface& surface, const Poles& poles,
                           const DateLine& dateLine) {
  return LaplaceSystem(surface, poles).longitudes(dateLine);
}

Points brechbuehlerPositions(const ClosedSurface& surface, const Poles& poles) {
  LaplaceSystem system(surface, poles);
  const Eigen::VectorXd colatitude = system.colatitudes();
  return onSphere(colatitude, system.longitudes(dateLine(surface, poles, colatitude)));
}

Points brechbuehlerPositions(const ClosedSurface& surface) {
  return brechbuehlerPositions(surface, extremePoles(surface));
}

}  // namespace sphere_propagation
