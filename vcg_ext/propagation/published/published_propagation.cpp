// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/published/published_propagation.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <string>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/linear_solvers.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/mesh/vertex_locator.h"
#include "vcg_ext/propagation/transfer/residual.h"
#include "vcg_ext/registration/principal_axes.h"
#include "vcg_ext/registration/rigid_alignment.h"
#include "vcg_ext/sphere/repair/untangling.h"

namespace sphere_propagation {
namespace {

/// Unit vectors and combinations of them that are shorter than this have no direction: they are
/// rounding.
constexpr double noLength = 1e-12;

/// Whether the spherical triangle's normal points inwards: a negative determinant of its corners.
bool pointsInwards(const Vector3& a, const Vector3& b, const Vector3& c) {
  return a.dot((b - a).cross(c - a)) < 0;
}

/// Weights of the ring of every vertex, one run after the other, each run of sum 1.
std::vector<double> convexWeights(const ClosedSurface& surface) {
  const double mean = meanEdgeLength(surface.vertices(), surface.faces());
  // An edge without length would take all of the weight, and more than fits a number.
  constexpr double minRelativeLength = 1e-12;
  std::vector<double> weights;
  weights.reserve(3 * static_cast<size_t>(surface.faceCount()));
  for (int v = 0; v < surface.vertexCount(); ++v) {
    const size_t first = weights.size();
    double sum = 0;
    for (int w : surface.ring(v)) {
      const double weight =
          1 / std::max((surface.vertex(v) - surface.vertex(w)).norm() / mean, minRelativeLength);
      weights.push_back(weight);
      sum += weight;
    }
    for (size_t i = first; i < weights.size(); ++i) weights[i] /= sum;
  }
  return weights;
}

/// Steps 4a and 4b: the target's vertices where step 4c looks for nearest ones. They serve that,
/// and the residual, only.
Points alignedVertices(const ClosedSurface& target, const VertexLocator& reference,
                       const PublishedParameters& parameters) {
  const PrincipalAxes axes = principalAxes(reference.points());
  Points points = target.vertices();
  if (parameters.anisotropicScaling)
    points = scaledToExtents(points, axes);
  else
    points.rowwise() += (axes.centroid.transpose() - points.colwise().mean()).eval();
  return alignRigidly(points, reference, parameters.icpIterations).motion.applyTo(points);
}

std::vector<double> distancesFrom(const ClosedSurface& reference, const Points& points) {
  const SurfaceLocator locator(reference.vertices(), reference.faces());
  std::vector<double> distances(static_cast<size_t>(points.rows()));
  for (size_t v = 0; v < distances.size(); ++v)
    distances[v] = locator.closest(points.row(static_cast<Eigen::Index>(v)).transpose()).distance;
  return distances;
}

}  // namespace

int FixedNodes::count() const {
  return static_cast<int>(std::count(isFixed.begin(), isFixed.end(), 1));
}

FixedNodes fixNodes(int vertexCount, const std::vector<VertexPair>& pairs,
                    const Points& referencePositions) {
  FixedNodes nodes{std::vector<char>(static_cast<size_t>(vertexCount), 0),
                   Points::Zero(vertexCount, 3)};
  for (const auto& [v, w] : pairs) {
    nodes.isFixed[v] = 1;
    nodes.positions.row(v) = referencePositions.row(w);
  }
  return nodes;
}

FixedNodes releaseInwardTriangles(const Triangles& faces, const FixedNodes& nodes) {
  FixedNodes kept = nodes;
  const auto position = [&](int v) { return Vector3(nodes.positions.row(v).transpose()); };
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const int a = faces(f, 0), b = faces(f, 1), c = faces(f, 2);
    if (!nodes.isFixed[a] || !nodes.isFixed[b] || !nodes.isFixed[c]) continue;
    if (!pointsInwards(position(a), position(b), position(c))) continue;
    for (int v : {a, b, c}) {
      kept.isFixed[v] = 0;
      kept.positions.row(v).setZero();
    }
  }
  return kept;
}

Points placeMovingNodes(const ClosedSurface& target, const FixedNodes& nodes) {
  const auto firstFixed =
      std::find(nodes.isFixed.begin(), nodes.isFixed.end(), 1) - nodes.isFixed.begin();
  if (firstFixed == target.vertexCount())
    throw PropagationError(Finding(Fault::NothingFixed, target.name()));
  std::vector<int> moving, row(static_cast<size_t>(target.vertexCount()), -1);
  for (int v = 0; v < target.vertexCount(); ++v)
    if (!nodes.isFixed[v]) {
      row[v] = static_cast<int>(moving.size());
      moving.push_back(v);
    }
  Points positions = nodes.positions;
  if (moving.empty()) return positions;

  const auto unknowns = static_cast<Eigen::Index>(moving.size());
  std::vector<Eigen::Triplet<double>> entries;  // the lower triangle of A
  Eigen::MatrixX3d b = Eigen::MatrixX3d::Zero(unknowns, 3);
  for (int i = 0; i < unknowns; ++i) {
    const IndexRange neighbours = target.ring(moving[i]);
    entries.emplace_back(i, i, neighbours.size());
    for (int w : neighbours)
      if (nodes.isFixed[w])
        b.row(i) += nodes.positions.row(w);
      else if (row[w] < i)
        entries.emplace_back(i, row[w], -1);
  }
  Eigen::SparseMatrix<double> A(unknowns, unknowns);
  A.setFromTriplets(entries.begin(), entries.end());
  // Positive definite: diagonally dominant, strictly so beside a fixed node, and every moving node
  // is connected to one.
  SparseCholesky factorisation;
  factorisation.compute(A);
  const Eigen::MatrixX3d x = factorisation.solve(b);
  for (int i = 0; i < unknowns; ++i) {
    const double length = x.row(i).norm();
    if (length > noLength)
      positions.row(moving[i]) = x.row(i) / length;
    else
      positions.row(moving[i]) = nodes.positions.row(firstFixed);
  }
  return positions;
}

Points smoothOnSphere(const ClosedSurface& surface, const Points& positions, int sweeps) {
  requireRange("number of smoothing sweeps", sweeps, Range::atLeast(0));
  Points before = positions, after(positions.rows(), 3);
  if (sweeps == 0) return before;
  const std::vector<double> weights = convexWeights(surface);
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    const double* weight = weights.data();
    for (int v = 0; v < surface.vertexCount(); ++v) {
      Eigen::RowVector3d combination = Eigen::RowVector3d::Zero();
      for (int w : surface.ring(v)) combination += *weight++ * before.row(w);
      const double length = combination.norm();
      if (length > noLength)
        after.row(v) = combination / length;
      else
        after.row(v) = before.row(v);
    }
    before.swap(after);
  }
  return before;
}

Correspondence findCorrespondence(const MappedSurface& reference, const ClosedSurface& target,
                                  const PublishedParameters& parameters,
                                  const std::vector<NodeAt>& anchors) {
  const VertexLocator referenceVertices(reference.surface().vertices());
  Correspondence found;
  found.aligned = alignedVertices(target, referenceVertices, parameters);
  const std::vector<VertexPair> pairs =
      mutualNearest(VertexLocator(found.aligned), referenceVertices);
  found.pairs = static_cast<int>(pairs.size());
  FixedNodes fixed = fixNodes(target.vertexCount(), pairs, reference.positions());
  for (const NodeAt& anchor : anchors) {
    fixed.isFixed[static_cast<size_t>(anchor.vertex)] = 1;
    fixed.positions.row(anchor.vertex) = anchor.position.transpose();
  }
  found.nodes = releaseInwardTriangles(target.faces(), fixed);
  return found;
}

TransferredMap propagateAsPublished(const MappedSurface& reference, const ClosedSurface& target,
                                    const PublishedParameters& parameters,
                                    const std::vector<NodeAt>& anchors) {
  const auto [aligned, pairs, nodes] = findCorrespondence(reference, target, parameters, anchors);
  if (nodes.count() == 0)
    throw PropagationError(Finding(Fault::NoCorrespondence, target.name())
                               .of(pairs)
                               .against(reference.surface().name()));
  const Points positions =
      smoothOnSphere(target, placeMovingNodes(target, nodes), parameters.smoothingSweeps);
  Untangled repaired = mend(target, positions);
  std::vector<double> distances = distancesFrom(reference.surface(), aligned);
  const Residual residual = residualOf(distances);
  return {std::move(repaired.map), repaired.repairedFaces, residual, std::move(distances)};
}

}  // namespace sphere_propagation
