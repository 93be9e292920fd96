// SPDX-License-Identifier: GPL-3.0-only
// W. E. Lorensen, H. E. Cline, Marching cubes, 1987; G. M. Nielson, B. Hamann, The asymptotic
// decider, 1991.

#include "vcg_ext/volume/marching_cubes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

// Corner c of a cell lies at (c & 1, c >> 1 & 1, c >> 2). Edge e runs along axis e / 4 from its
// lower corner.
struct Edge {
  int axis, corner;
};
constexpr std::array<Edge, 12> edges{{{0, 0},
                                      {0, 2},
                                      {0, 4},
                                      {0, 6},
                                      {1, 0},
                                      {1, 1},
                                      {1, 4},
                                      {1, 5},
                                      {2, 0},
                                      {2, 1},
                                      {2, 2},
                                      {2, 3}}};
/// The corners of each face, counter-clockwise seen from outside the cell.
constexpr std::array<std::array<int, 4>, 6> faceCorners{
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

constexpr int edgeBetween(int a, int b) {
  const int low = a < b ? a : b, axis = (a ^ b) == 1 ? 0 : (a ^ b) == 2 ? 1 : 2;
  for (int e = 0; e < 12; ++e)
    if (edges[static_cast<size_t>(e)].axis == axis && edges[static_cast<size_t>(e)].corner == low)
      return e;
  return -1;
}

/// faceEdges[f][m] joins corners m and m + 1 of face f; inOneFace[e][g]: both edges bound one face.
struct Tables {
  std::array<std::array<int, 4>, 6> faceEdges{};
  std::array<std::array<bool, 12>, 12> inOneFace{};
  constexpr Tables() {
    for (size_t f = 0; f < 6; ++f) {
      for (size_t m = 0; m < 4; ++m)
        faceEdges[f][m] = edgeBetween(faceCorners[f][m], faceCorners[f][(m + 1) % 4]);
      for (size_t m = 0; m < 4; ++m)
        for (size_t l = 0; l < 4; ++l)
          inOneFace[static_cast<size_t>(faceEdges[f][m])][static_cast<size_t>(faceEdges[f][l])] =
              true;
    }
  }
};
constexpr Tables tables;

class Marcher {
 public:
  Marcher(const ScalarGrid& grid, double isoValue, FaceRule rule)
      : grid_(grid), isoValue_(isoValue), rule_(rule) {
    const size_t slice =
        static_cast<size_t>(grid.size[0] + 2) * static_cast<size_t>(grid.size[1] + 2);
    for (auto& plane : vertexAt_) plane.assign(3 * slice, -1);
  }

  IsoSurface run() {
    // Cells are named by their lower corner; the border cells have corners outside the grid.
    for (int k = -1; k < grid_.size[2]; ++k) {
      for (int j = -1; j < grid_.size[1]; ++j)
        for (int i = -1; i < grid_.size[0]; ++i) processCell(i, j, k);
      std::swap(vertexAt_[0], vertexAt_[1]);
      std::fill(vertexAt_[1].begin(), vertexAt_[1].end(), -1);
    }
    if (points_.size() > static_cast<size_t>(std::numeric_limits<int>::max()))
      throw ArgumentError("Marching cubes: the surface has too many vertices to be numbered.");
    IsoSurface result;
    result.vertices.resize(static_cast<Eigen::Index>(points_.size()), 3);
    for (size_t v = 0; v < points_.size(); ++v)
      result.vertices.row(static_cast<Eigen::Index>(v)) = points_[v].transpose();
    result.faces.resize(static_cast<Eigen::Index>(triangles_.size()), 3);
    for (size_t f = 0; f < triangles_.size(); ++f)
      result.faces.row(static_cast<Eigen::Index>(f)) << triangles_[f][0], triangles_[f][1],
          triangles_[f][2];
    return result;
  }

 private:
  /// The sample relative to the iso value; outside the grid below all.
  double value(int i, int j, int k) const {
    if (i < 0 || j < 0 || k < 0 || i >= grid_.size[0] || j >= grid_.size[1] || k >= grid_.size[2])
      return -std::numeric_limits<double>::infinity();
    return static_cast<double>(grid_(i, j, k)) - isoValue_;
  }

  void processCell(int i, int j, int k) {
    bool any = false, all = true;
    for (size_t c = 0; c < 8; ++c) {
      const int n = static_cast<int>(c);
      values_[c] = value(i + (n & 1), j + (n >> 1 & 1), k + (n >> 2));
      inside_[c] = values_[c] > 0;
      any = any || inside_[c];
      all = all && inside_[c];
    }
    if (!any || all) return;
    cell_ = {i, j, k};
    std::array<int, 12> next{};  // edge by edge along the outlines, -1 where none passes
    next.fill(-1);
    for (size_t f = 0; f < 6; ++f) traceFace(f, next);
    for (size_t start = 0; start < 12; ++start) {
      outline_.clear();
      for (size_t e = start; next[e] >= 0;) {
        outline_.push_back(e);
        const size_t following = static_cast<size_t>(next[e]);
        next[e] = -1;
        e = following;
      }
      if (!outline_.empty()) fillOutline();
    }
  }

  /// What runs over a face of the cell: going round it counter-clockwise seen from outside, each
  /// piece of the outline comes from an edge where one enters the inside and leads to one where one
  /// leaves it. The neighbour goes round the other way, so its piece runs the other way, as that of
  /// an oriented surface should.
  void traceFace(size_t f, std::array<int, 12>& next) const {
    const auto& corners = faceCorners[f];
    const auto& faceEdges = tables.faceEdges[f];
    const auto in = [&](size_t m) { return inside_[static_cast<size_t>(corners[m % 4])]; };
    const auto at = [&](size_t m) { return values_[static_cast<size_t>(corners[m % 4])]; };
    const bool ambiguous = in(0) == in(2) && in(1) == in(3) && in(0) != in(1);
    const bool joined =
        ambiguous && rule_ == FaceRule::AsymptoticDecider &&
        at(in(0) ? 0 : 1) * at(in(0) ? 2 : 3) > at(in(0) ? 1 : 0) * at(in(0) ? 3 : 2);
    for (size_t m = 0; m < 4; ++m) {
      if (in(m) || !in(m + 1)) continue;  // not entering between corners m and m + 1
      size_t leaving = m + 1;
      if (joined)
        leaving = m + 3;  // round the corner outside
      else
        while (!in(leaving) || in(leaving + 1)) ++leaving;
      next[static_cast<size_t>(faceEdges[m])] = faceEdges[leaving % 4];
    }
  }

  /// The vertex on an edge of the cell, made when it is asked for first.
  int vertex(size_t e) {
    const Edge edge = edges[e];
    const int low[3] = {edge.corner & 1, edge.corner >> 1 & 1, edge.corner >> 2};
    int& index =
        vertexAt_[static_cast<size_t>(low[2])][3 * (static_cast<size_t>(cell_[1] + 1 + low[1]) *
                                                        static_cast<size_t>(grid_.size[0] + 2) +
                                                    static_cast<size_t>(cell_[0] + 1 + low[0])) +
                                               static_cast<size_t>(edge.axis)];
    if (index < 0) {
      const double a = values_[static_cast<size_t>(edge.corner)],
                   b = values_[static_cast<size_t>(edge.corner | 1 << edge.axis)];
      const double t =
          std::isfinite(a) && std::isfinite(b) ? std::clamp(a / (a - b), 0.001, 0.999) : 0.5;
      Vector3 point(cell_[0] + low[0], cell_[1] + low[1], cell_[2] + low[2]);
      point[edge.axis] += t;
      index = static_cast<int>(points_.size());
      points_.push_back(grid_.origin + point.cwiseProduct(grid_.spacing));
    }
    return index;
  }

  /// Triangulates the outline with the least sum of squared diagonals, none of them in a face of
  /// the cell.
  void fillOutline() {
    const size_t n = outline_.size();
    std::array<int, 12> v{};
    for (size_t p = 0; p < n; ++p) v[p] = vertex(outline_[p]);
    if (n == 3) {
      triangles_.push_back({v[0], v[1], v[2]});
      return;
    }
    constexpr double forbidden = 1e300;
    const auto point = [&](size_t p) -> const Vector3& {
      return points_[static_cast<size_t>(v[p])];
    };
    std::array<std::array<double, 12>, 12> cost{};  // of the polygon p .. q
    std::array<std::array<size_t, 12>, 12> apex{};  // of its triangle at the side (p, q)
    for (size_t length = 2; length < n; ++length)
      for (size_t p = 0; p + length < n; ++p) {
        const size_t q = p + length;
        cost[p][q] = std::numeric_limits<double>::infinity();
        for (size_t r = p + 1; r < q; ++r)
          if (cost[p][r] + cost[r][q] < cost[p][q])
            cost[p][q] = cost[p][r] + cost[r][q], apex[p][q] = r;
        if (length + 1 < n)
          cost[p][q] += tables.inOneFace[outline_[p]][outline_[q]]
                            ? forbidden
                            : (point(p) - point(q)).squaredNorm();
      }
    if (cost[0][n - 1] < forbidden) {
      fill(v, apex, 0, n - 1);
      return;
    }
    Vector3 middle = Vector3::Zero();
    for (size_t p = 0; p < n; ++p) middle += point(p) / static_cast<double>(n);
    const int centre = static_cast<int>(points_.size());
    points_.push_back(middle);
    for (size_t p = 0; p < n; ++p) triangles_.push_back({v[p], v[(p + 1) % n], centre});
  }

  void fill(const std::array<int, 12>& v, const std::array<std::array<size_t, 12>, 12>& apex,
            size_t p, size_t q) {
    if (q - p < 2) return;
    const size_t r = apex[p][q];
    triangles_.push_back({v[p], v[r], v[q]});
    fill(v, apex, p, r);
    fill(v, apex, r, q);
  }

  const ScalarGrid& grid_;
  double isoValue_;
  FaceRule rule_;
  // The vertices on the edges that start in the lower and the upper plane of the cells at hand: 3
  // axes per grid point.
  std::array<std::vector<int>, 2> vertexAt_;
  std::vector<Vector3> points_;
  std::vector<std::array<int, 3>> triangles_;
  // Of the cell at hand.
  std::array<int, 3> cell_{};
  std::array<double, 8> values_{};
  std::array<bool, 8> inside_{};
  std::vector<size_t> outline_;
};

}  // namespace

IsoSurface marchingCubes(const ScalarGrid& grid, double isoValue, FaceRule rule) {
  size_t count = 1;
  for (int axis = 0; axis < 3; ++axis) count *= static_cast<size_t>(std::max(grid.size[axis], 0));
  const bool sound = grid.size.minCoeff() > 0 && grid.values.size() == count &&
                     grid.spacing.minCoeff() > 0 && grid.spacing.allFinite() &&
                     grid.origin.allFinite() && std::isfinite(isoValue);
  if (!sound) {
    std::ostringstream text;
    text << "Marching cubes needs a grid with samples, a positive spacing and a finite iso value, "
            "but the grid has size "
         << grid.size.transpose() << ", " << grid.values.size() << " values, spacing "
         << grid.spacing.transpose() << ", and the iso value is " << isoValue << ".";
    throw ArgumentError(text.str());
  }
  return Marcher(grid, isoValue, rule).run();
}

IsoSurface largestPart(const IsoSurface& surface) {
  const Eigen::Index n = surface.vertices.rows();
  std::vector<Eigen::Index> parent(static_cast<size_t>(n));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](Eigen::Index v) {
    while (parent[static_cast<size_t>(v)] != v)
      v = parent[static_cast<size_t>(v)] =
          parent[static_cast<size_t>(parent[static_cast<size_t>(v)])];
    return v;
  };
  for (Eigen::Index f = 0; f < surface.faces.rows(); ++f)
    for (int k = 1; k < 3; ++k) {
      const Eigen::Index a = root(surface.faces(f, 0)), b = root(surface.faces(f, k));
      parent[static_cast<size_t>(std::max(a, b))] =
          std::min(a, b);  // so a part's root is its smallest vertex
    }
  std::vector<Eigen::Index> count(static_cast<size_t>(n), 0);
  for (Eigen::Index v = 0; v < n; ++v) ++count[static_cast<size_t>(root(v))];
  const Eigen::Index kept = std::max_element(count.begin(), count.end()) - count.begin();

  IsoSurface result;
  std::vector<int> index(static_cast<size_t>(n), -1);
  int vertices = 0;
  Eigen::Index faces = 0;
  for (Eigen::Index v = 0; v < n; ++v)
    if (root(v) == kept) index[static_cast<size_t>(v)] = vertices++;
  for (Eigen::Index f = 0; f < surface.faces.rows(); ++f)
    faces += root(surface.faces(f, 0)) == kept;
  result.vertices.resize(vertices, 3);
  result.faces.resize(faces, 3);
  for (Eigen::Index v = 0; v < n; ++v)
    if (index[static_cast<size_t>(v)] >= 0)
      result.vertices.row(index[static_cast<size_t>(v)]) = surface.vertices.row(v);
  faces = 0;
  for (Eigen::Index f = 0; f < surface.faces.rows(); ++f) {
    if (root(surface.faces(f, 0)) != kept) continue;
    for (int k = 0; k < 3; ++k)
      result.faces(faces, k) = index[static_cast<size_t>(surface.faces(f, k))];
    ++faces;
  }
  return result;
}

}  // namespace sphere_propagation
