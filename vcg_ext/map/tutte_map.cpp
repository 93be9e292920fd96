// W. T. Tutte, How to draw a graph, 1963.

#include "vcg_ext/map/tutte_map.h"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <vector>

namespace sphere_propagation {
namespace {

/// Of the polygon in the plane: at a colatitude of 79 degrees, so that most of the northern hemisphere is inside. Its
/// sides span at most a third of the circle, less than a half, so the faces at the south pole do not flip.
constexpr double radius = 5;

}  // namespace

Points tuttePositions(const ClosedSurface& surface) {
  int pole = 0;
  for (int v = 1; v < surface.vertexCount(); ++v)
    if (surface.ring(v).size() > surface.ring(pole).size()) pole = v;

  // In the plane at z = 1, seen from above. Counter-clockwise seen from the south pole is clockwise from there.
  Points positions(surface.vertexCount(), 3);
  std::vector<char> fixed(static_cast<size_t>(surface.vertexCount()), 0);
  positions.row(pole) << 0, 0, -1;
  fixed[pole] = 1;
  const IndexRange ring = surface.ring(pole);
  for (int i = 0; i < ring.size(); ++i) {
    const double angle = -2 * pi * i / ring.size();
    positions.row(ring[i]) << radius * std::cos(angle), radius * std::sin(angle), 1;
    fixed[ring[i]] = 1;
  }

  std::vector<int> unknown(fixed.size(), -1), vertex;
  for (int v = 0; v < surface.vertexCount(); ++v)
    if (!fixed[v]) {
      unknown[v] = static_cast<int>(vertex.size());
      vertex.push_back(v);
    }
  const auto count = static_cast<Eigen::Index>(vertex.size());
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixX3d right = Eigen::MatrixX3d::Zero(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const IndexRange neighbours = surface.ring(vertex[static_cast<size_t>(i)]);
    entries.emplace_back(i, i, neighbours.size());
    for (int w : neighbours)
      if (fixed[w])
        right.row(i) += positions.row(w);
      else
        entries.emplace_back(i, unknown[w], -1.0);
  }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
  const Eigen::MatrixX3d solution = solver.solve(right);
  for (Eigen::Index i = 0; i < count; ++i) positions.row(vertex[static_cast<size_t>(i)]) = solution.row(i);
  positions.rowwise().normalize();
  return positions;
}

}  // namespace sphere_propagation
