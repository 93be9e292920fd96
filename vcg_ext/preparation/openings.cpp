// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/preparation/openings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace sphere_propagation {
namespace {

using Ring = std::vector<int>;  // half-edges with nothing on their other side, one behind another

/// Finds the rims of a mesh, and takes care of what touches itself.
class Rims {
 public:
  explicit Rims(BrokenMesh& mesh) : mesh_(mesh), neighbours_(mesh.source.size()) {
    for (int f = 0; f < mesh.faceCount(); ++f)
      for (int k = 0; k < 3; ++k) {
        join(mesh.faces(f, k), mesh.faces(f, (k + 1) % 3));
      }
    trace();
  }

  const std::vector<Ring>& rings() const { return rings_; }
  const std::vector<int>& neighbours(int v) const { return neighbours_[v]; }
  bool joined(int a, int b) const {
    return std::binary_search(neighbours_[a].begin(), neighbours_[a].end(), b);
  }
  void join(int a, int b) {
    insert(a, b);
    insert(b, a);
  }
  void addVertices(size_t count) { neighbours_.resize(neighbours_.size() + count); }
  int origin(int h) const { return mesh_.faces(h / 3, h % 3); }
  int target(int h) const { return mesh_.faces(h / 3, (h + 1) % 3); }

 private:
  void insert(int a, int b) {
    std::vector<int>& list = neighbours_[a];
    const auto place = std::lower_bound(list.begin(), list.end(), b);
    if (place == list.end() || *place != b) list.insert(place, b);
  }

  void trace() {
    const EdgeTable edges(mesh_.faces);
    std::vector<int> from(mesh_.source.size(), -1);  // the half-edge on the rim that starts there
    std::vector<int> all;
    for (int h = 0; h < 3 * mesh_.faceCount(); ++h)
      if (edges.size(edges.edgeOf(h)) == 1) {
        all.push_back(h);
        if (from[origin(h)] < 0) from[origin(h)] = h;
      }
    std::vector<char> used(3 * mesh_.faceLid.size(), 0);
    std::vector<int> one(mesh_.source.size());  // what each vertex is once those that were one are
    std::iota(one.begin(), one.end(), 0);
    for (const int start : all) {
      if (used[start]) continue;
      Ring ring;
      int h = start;
      while (h >= 0 && !used[h]) {
        used[h] = 1;
        ring.push_back(h);
        h = from[target(h)];
      }
      if (h == start) split(ring, one);
    }
    for (int h = 0; h < 3 * mesh_.faceCount(); ++h)
      mesh_.faces(h / 3, h % 3) = nowOf(one, origin(h));
  }

  static int nowOf(const std::vector<int>& one, int v) {
    while (one[v] != v) v = one[v];
    return v;
  }

  /// Splits a ring where it comes back to what was one vertex, which becomes one again.
  void split(const Ring& ring, std::vector<int>& one) {
    Ring way;                 // whose origins are all different
    std::vector<int> places;  // the vertex at which each begins
    std::vector<Ring> found;
    for (const int h : ring) {
      int at = nowOf(one, origin(h));
      for (size_t i = 0; i < way.size(); ++i) {
        if (places[i] != at && !isOne(places[i], at, way.size() - i)) continue;
        found.emplace_back(way.begin() + static_cast<long>(i), way.end());
        way.resize(i);
        if (places[i] != at) {
          one[at] = places[i];
          const std::vector<int> around = neighbours_[at];
          for (const int w : around) join(places[i], w);
          at = places[i];
        }
        places.resize(i);
        break;
      }
      way.push_back(h);
      places.push_back(at);
    }
    if (!way.empty()) found.push_back(way);
    for (Ring& part : found) rings_.push_back(std::move(part));
  }

  /// Whether two vertices were one and can be so again: no edges would lie on each other, but for
  /// the two of a crack of two edges.
  bool isOne(int a, int b, size_t edgesBetween) const {
    if (mesh_.separated[a] != mesh_.separated[b] || joined(a, b)) return false;
    std::vector<int> common;
    std::set_intersection(neighbours_[a].begin(), neighbours_[a].end(), neighbours_[b].begin(),
                          neighbours_[b].end(), std::back_inserter(common));
    return common.size() == (edgesBetween == 2 ? 1U : 0U);
  }

  BrokenMesh& mesh_;
  std::vector<std::vector<int>> neighbours_;  // of each vertex, in ascending order
  std::vector<Ring> rings_;
};

/// Values round a ring, each the weighted mean of its neighbourhood.
template <class Rows>
Rows smoothedRound(const Rows& values, int reach) {
  Rows result = Rows::Zero(values.rows(), values.cols());
  const Eigen::Index n = values.rows();
  double total = 0;
  for (int d = -reach; d <= reach; ++d) {
    const double weight = 1 + std::cos(pi * d / (reach + 1.0));
    total += weight;
    for (Eigen::Index i = 0; i < n; ++i)
      result.row(i) += weight * values.row(((i + d) % n + n) % n);
  }
  return result / total;
}

/// Where the surface would go on at each point of the rim: away from the wall within a few rings,
/// across the rim, and much the same as beside it, so that noise at the rim does not count; but
/// never wider than the rim, beyond which a wall that widens towards it would blow up.
Points onwardOf(const BrokenMesh& mesh, const Rims& rims, const std::vector<int>& rim) {
  constexpr int depth = 3;
  const auto n = static_cast<Eigen::Index>(rim.size());
  std::vector<int> sorted = rim;
  std::sort(sorted.begin(), sorted.end());
  Vector3 across = Vector3::Zero();  // the normal of the rim's plane, should it lie in one
  for (Eigen::Index i = 0; i < n; ++i)
    across += (mesh.vertex(rim[i]) - mesh.vertex(rim[0]))
                  .cross(mesh.vertex(rim[(i + 1) % n]) - mesh.vertex(rim[0]));
  across = across.stableNormalized();
  Points along(n, 3);
  for (Eigen::Index i = 0; i < n; ++i)
    along.row(i) = (mesh.vertex(rim[(i + 1) % n]) - mesh.vertex(rim[(i + n - 1) % n])).transpose();
  const int reach = static_cast<int>(std::min<Eigen::Index>((n - 1) / 2, 2 + n / 20));
  along = smoothedRound(along, reach);
  Points onward = Points::Zero(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector3 here = mesh.vertex(rim[i]);
    std::vector<int> ball{rim[i]};
    size_t begin = 0;
    for (int d = 0; d < depth; ++d) {
      const size_t end = ball.size();
      for (size_t j = begin; j < end; ++j)
        for (const int w : rims.neighbours(ball[j]))
          if (std::find(ball.begin(), ball.end(), w) == ball.end() &&
              !std::binary_search(sorted.begin(), sorted.end(), w))
            ball.push_back(w);
      begin = end;
    }
    Vector3 away = Vector3::Zero();
    for (size_t j = 1; j < ball.size(); ++j) away += here - mesh.vertex(ball[j]);
    onward.row(i) = away.stableNormalized().transpose();
  }
  onward = smoothedRound(onward, reach);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector3 tangent = along.row(i).transpose().stableNormalized();
    Vector3 way = onward.row(i).transpose();
    way -= tangent * tangent.dot(way);
    const Vector3 outside = tangent.cross(across).stableNormalized();
    if (const double wider = way.dot(outside); wider > 0) way -= wider * outside;
    onward.row(i) = way.stableNormalized().transpose();
  }
  return onward;
}

Rim rimOf(const BrokenMesh& mesh, const Rims& rims, const Ring& ring, const std::vector<int>& rim,
          LidShape shape) {
  const auto n = static_cast<Eigen::Index>(rim.size());
  Rim result{Points(n, 3), Points(n, 3), Eigen::VectorXd(n), Points::Zero(n, 3), {}};
  for (Eigen::Index i = 0; i < n; ++i) {
    result.points.row(i) = mesh.vertices.row(rim[i]);
    result.wall.row(i) =
        areaVector(mesh.vertices, mesh.faces, ring[i] / 3).stableNormalized().transpose();
    double sum = 0;
    for (const int w : rims.neighbours(rim[i]))
      sum += (mesh.vertex(w) - mesh.vertex(rim[i])).norm();
    result.spacing[i] = sum / static_cast<double>(rims.neighbours(rim[i]).size());
  }
  // Where a cut left tiny edges the lid is to be as fine as the wall, not as those.
  const double least = 0.5 * result.spacing.mean();
  result.spacing = smoothedRound(Eigen::VectorXd(result.spacing.cwiseMax(least)), 2);
  if (shape == LidShape::Curved) result.onward = onwardOf(mesh, rims, rim);
  result.joined = [&rims, rim](int i, int j) { return rims.joined(rim[i], rim[j]); };
  return result;
}

}  // namespace

std::vector<Opening> closeOpenings(BrokenMesh& mesh, LidShape shape, const Progress& progress) {
  Rims rims(mesh);
  std::vector<Opening> openings;
  size_t done = 0;
  for (Ring ring : rims.rings()) {
    report(progress, static_cast<double>(done++) / static_cast<double>(rims.rings().size()));
    // The lid runs round the other way.
    std::reverse(ring.begin(), ring.end());
    std::vector<int> rim;
    for (const int h : ring) rim.push_back(rims.target(h));
    Opening opening;
    opening.edges = static_cast<int>(ring.size());
    for (const int h : ring) {
      opening.perimeter += (mesh.vertex(rims.origin(h)) - mesh.vertex(rims.target(h))).norm();
      opening.centre += mesh.vertex(rims.origin(h)) / static_cast<double>(ring.size());
    }
    if (ring.size() == 2) {
      openings.push_back(opening);
      continue;
    }
    if (ring.size() == 3 && ring[0] / 3 == ring[1] / 3 && ring[1] / 3 == ring[2] / 3) continue;
    const Lid lid = makeLid(rimOf(mesh, rims, ring, rim, shape), shape);
    const int number = static_cast<int>(openings.size()) + 1;
    const int first = mesh.addVertices(lid.vertices, number);
    rims.addVertices(static_cast<size_t>(lid.vertices.rows()));
    Triangles faces = lid.faces;
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
      for (int k = 0; k < 3; ++k) {
        int& v = faces(f, k);
        v = v < opening.edges ? rim[v] : first + v - opening.edges;
      }
      for (int k = 0; k < 3; ++k) rims.join(faces(f, k), faces(f, (k + 1) % 3));
    }
    mesh.addFaces(faces, number, mesh.turned[ring[0] / 3]);
    opening.newVertices = static_cast<int>(lid.vertices.rows());
    opening.newFaces = static_cast<int>(faces.rows());
    openings.push_back(opening);
  }
  return openings;
}

}  // namespace sphere_propagation
