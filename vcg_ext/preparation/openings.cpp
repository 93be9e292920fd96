// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/preparation/openings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "vcg_ext/preparation/orientation.h"

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

/// The vertices within so many edges of one on the rim, which comes first, by ways off the rim.
std::vector<int> within(const Rims& rims, const std::vector<int>& sortedRim, int vertex,
                        int depth) {
  std::vector<int> ball{vertex};
  size_t begin = 0;
  for (int d = 0; d < depth; ++d) {
    const size_t end = ball.size();
    for (size_t j = begin; j < end; ++j)
      for (const int w : rims.neighbours(ball[j]))
        if (std::find(ball.begin(), ball.end(), w) == ball.end() &&
            !std::binary_search(sortedRim.begin(), sortedRim.end(), w))
          ball.push_back(w);
    begin = end;
  }
  return ball;
}

/// Length of the edges near a point of the rim: those that end on it do not count, since a cut
/// makes tiny ones there; where there are no others, its own.
double edgeLengthNear(const BrokenMesh& mesh, const Rims& rims, const std::vector<int>& sortedRim,
                      int vertex) {
  double sum = 0, own = 0;
  int count = 0;
  const std::vector<int> ball = within(rims, sortedRim, vertex, 3);
  for (size_t j = 1; j < ball.size(); ++j)
    for (const int w : rims.neighbours(ball[j]))
      if (!std::binary_search(sortedRim.begin(), sortedRim.end(), w)) {
        sum += (mesh.vertex(w) - mesh.vertex(ball[j])).norm();
        ++count;
      }
  if (count > 0) return sum / count;
  const std::vector<int>& around = rims.neighbours(vertex);
  for (const int w : around) own += (mesh.vertex(w) - mesh.vertex(vertex)).norm();
  return own / static_cast<double>(around.size());
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
    const std::vector<int> ball = within(rims, sorted, rim[i], depth);
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
  std::vector<int> sorted = rim;
  std::sort(sorted.begin(), sorted.end());
  Rim result{Points(n, 3), Points(n, 3), Eigen::VectorXd(n), Points::Zero(n, 3), {}};
  for (Eigen::Index i = 0; i < n; ++i) {
    result.points.row(i) = mesh.vertices.row(rim[i]);
    result.wall.row(i) =
        areaVector(mesh.vertices, mesh.faces, ring[i] / 3).stableNormalized().transpose();
    result.spacing[i] = edgeLengthNear(mesh, rims, sorted, rim[i]);
  }
  // Where there is nothing but tiny edges the lid need not be as fine.
  const double least = 0.5 * result.spacing.mean();
  result.spacing = smoothedRound(Eigen::VectorXd(result.spacing.cwiseMax(least)), 2);
  if (shape == LidShape::Curved) result.onward = onwardOf(mesh, rims, rim);
  result.joined = [&rims, rim](int i, int j) { return rims.joined(rim[i], rim[j]); };
  return result;
}

/// One side of a wall, open at its rim.
struct Shell {
  std::vector<int> faces;
  Ring ring;
  std::vector<int> rim;  // origins along the ring
  double perimeter = 0;
  Vector3 normal = Vector3::Zero();  // of the rim, by the right hand along the ring
  Vector3 centre = Vector3::Zero();  // of the rim
};

/// Six times the volume of a shell and of the fan on its rim: positive where faces look outwards.
double volumeOf(const BrokenMesh& mesh, const Shell& shell) {
  double volume = 0;
  for (const int f : shell.faces)
    volume +=
        areaVector(mesh.vertices, mesh.faces, f).dot(mesh.vertex(mesh.faces(f, 0)) - shell.centre);
  return volume;  // the fan's corners are coplanar with its apex
}

/// How often a shell with the fan on its rim goes round a point; near 1 or -1 inside.
double windingOf(const BrokenMesh& mesh, const Shell& shell, const Vector3& point) {
  const auto angle = [&](const Vector3& a, const Vector3& b, const Vector3& c) {
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    return 2 * std::atan2(a.dot(b.cross(c)),
                          la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  };
  double sum = 0;
  for (const int f : shell.faces)
    sum += angle(mesh.vertex(mesh.faces(f, 0)) - point, mesh.vertex(mesh.faces(f, 1)) - point,
                 mesh.vertex(mesh.faces(f, 2)) - point);
  for (size_t i = 0; i < shell.rim.size(); ++i)
    sum += angle(shell.centre - point, mesh.vertex(shell.rim[(i + 1) % shell.rim.size()]) - point,
                 mesh.vertex(shell.rim[i]) - point);
  return sum / (4 * pi);
}

/// The two largest parts of a mesh, with their main rims; nothing where they have none.
std::optional<std::pair<Shell, Shell>> largestShells(const BrokenMesh& mesh, const Rims& rims) {
  constexpr double smallest = 0.1, mainRim = 2;
  const EdgeTable edges(mesh.faces);
  DisjointSets sets(mesh.faceCount());
  for (int e = 0; e < edges.count(); ++e)
    for (int i = 1; i < edges.size(e); ++i)
      sets.unite(edges.halfEdge(e, 0) / 3, edges.halfEdge(e, i) / 3);
  std::vector<double> area(mesh.faceLid.size(), 0);
  for (int f = 0; f < mesh.faceCount(); ++f)
    area[sets.find(f)] += areaVector(mesh.vertices, mesh.faces, f).norm();
  const auto largest = static_cast<int>(std::max_element(area.begin(), area.end()) - area.begin());
  const double most = area[largest];
  area[largest] = 0;
  const auto next = static_cast<int>(std::max_element(area.begin(), area.end()) - area.begin());
  if (area[next] < smallest * most || area[next] <= 0) return std::nullopt;
  std::pair<Shell, Shell> shells;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    if (sets.find(f) == largest) shells.first.faces.push_back(f);
    if (sets.find(f) == next) shells.second.faces.push_back(f);
  }
  double second[2]{};
  for (const Ring& ring : rims.rings()) {
    const int part = sets.find(ring.front() / 3);
    if (part != largest && part != next) continue;
    Shell& shell = part == largest ? shells.first : shells.second;
    double perimeter = 0;
    for (const int h : ring)
      perimeter += (mesh.vertex(rims.target(h)) - mesh.vertex(rims.origin(h))).norm();
    double& other = second[part == largest ? 0 : 1];
    other = std::max(other, std::min(perimeter, shell.perimeter));
    if (perimeter <= shell.perimeter) continue;
    shell.perimeter = perimeter;
    shell.ring = ring;
  }
  for (Shell* shell : {&shells.first, &shells.second}) {
    if (shell->ring.size() < 3 || shell->perimeter < mainRim * second[shell == &shells.second])
      return std::nullopt;
    for (const int h : shell->ring) {
      shell->rim.push_back(rims.origin(h));
      shell->centre += mesh.vertex(rims.origin(h)) / static_cast<double>(shell->ring.size());
    }
    for (const int h : shell->ring)
      shell->normal += (mesh.vertex(rims.origin(h)) - shell->centre)
                           .cross(mesh.vertex(rims.target(h)) - shell->centre);
  }
  return shells;
}

/// Whether the first lies round the second, and their rims are those of one wall.
bool isWall(const BrokenMesh& mesh, const Shell& outer, const Shell& inner) {
  constexpr double alike = 0.7, narrowest = 0.3, farthest = 0.7, mostly = 0.9;
  const double cosine =
      std::fabs(outer.normal.stableNormalized().dot(inner.normal.stableNormalized()));
  if (cosine < alike || inner.perimeter < narrowest * outer.perimeter) return false;
  const double radius = outer.perimeter / (2 * pi);
  for (const int v : inner.rim) {
    double nearest = HUGE_VAL;
    for (const int w : outer.rim)
      nearest = std::min(nearest, (mesh.vertex(v) - mesh.vertex(w)).norm());
    if (nearest > farthest * radius) return false;
  }
  constexpr size_t samples = 64;
  const size_t step = std::max<size_t>(1, inner.faces.size() / samples);
  int inside = 0, all = 0;
  for (size_t i = 0; i < inner.faces.size(); i += step, ++all) {
    Vector3 point = Vector3::Zero();
    for (int k = 0; k < 3; ++k) point += mesh.vertex(mesh.faces(inner.faces[i], k)) / 3;
    inside += std::fabs(windingOf(mesh, outer, point)) > 0.5;
  }
  return inside >= mostly * all;
}

/// The outer and the inner side of a wall.
std::optional<std::pair<Shell, Shell>> wallOf(const BrokenMesh& mesh, const Rims& rims) {
  auto shells = largestShells(mesh, rims);
  if (!shells) return std::nullopt;
  if (!isWall(mesh, shells->first, shells->second)) {
    std::swap(shells->first, shells->second);
    if (!isWall(mesh, shells->first, shells->second)) return std::nullopt;
  }
  return shells;
}

/// Faces between two rims, as indices into both, one behind the other: on the left of the first,
/// which runs as it does in its shell, and of the second, which runs the other way round.
Triangles zipped(const BrokenMesh& mesh, const std::vector<int>& first,
                 const std::vector<int>& second) {
  const auto n = static_cast<int>(first.size()), m = static_cast<int>(second.size());
  int start = 0;
  double nearest = HUGE_VAL;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j)
      if (const double d = (mesh.vertex(first[i]) - mesh.vertex(second[j])).squaredNorm();
          d < nearest) {
        nearest = d;
        start = i * m + j;
      }
  const auto at = [&](int i) { return (start / m + i) % n; };
  const auto over = [&](int j) { return (start % m + j) % m; };
  // Cost of all lines up to the one from point i to point j.
  Eigen::MatrixXd cost = Eigen::MatrixXd::Constant(n + 1, m + 1, HUGE_VAL);
  cost(0, 0) = 0;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= m; ++j) {
      if (i + j == 0) continue;
      const double line = (mesh.vertex(first[at(i)]) - mesh.vertex(second[over(j)])).squaredNorm();
      const double before =
          std::min(i > 0 ? cost(i - 1, j) : HUGE_VAL, j > 0 ? cost(i, j - 1) : HUGE_VAL);
      cost(i, j) = before + line;
    }
  Triangles faces(n + m, 3);
  for (int i = n, j = m, f = 0; i + j > 0; ++f)
    if (j == 0 || (i > 0 && cost(i - 1, j) <= cost(i, j - 1))) {
      faces.row(f) << at(i), at(i - 1), n + over(j);
      --i;
    } else {
      faces.row(f) << n + over(j - 1), n + over(j), at(i);
      --j;
    }
  return faces;
}

}  // namespace

bool hasShells(const BrokenMesh& mesh) {
  BrokenMesh copy = mesh;
  orientAlike(copy);
  const Rims rims(copy);
  return wallOf(copy, rims).has_value();
}

std::optional<Opening> joinShells(BrokenMesh& mesh) {
  if (!hasShells(mesh)) return std::nullopt;
  orientAlike(mesh);
  {
    const Rims rims(mesh);
    const auto shells = wallOf(mesh, rims);
    for (const bool outer : {true, false}) {
      const Shell& shell = outer ? shells->first : shells->second;
      if ((volumeOf(mesh, shell) > 0) == outer) continue;
      for (const int f : shell.faces) turnFace(mesh, f);
    }
  }
  const Rims rims(mesh);
  const auto shells = wallOf(mesh, rims);
  std::vector<int> rim = shells->first.rim, inner = shells->second.rim;
  std::reverse(inner.begin(), inner.end());
  const Triangles zip = zipped(mesh, rim, inner);
  std::vector<int> sorted[2]{rim, inner};
  for (std::vector<int>& part : sorted) std::sort(part.begin(), part.end());
  const size_t outerSize = rim.size();
  rim.insert(rim.end(), inner.begin(), inner.end());
  const auto n = static_cast<Eigen::Index>(rim.size());
  Rim both{Points(n, 3), Points::Zero(n, 3), Eigen::VectorXd(n), Points::Zero(n, 3), {}};
  Opening opening;
  for (size_t i = 0; i < rim.size(); ++i) {
    both.points.row(static_cast<Eigen::Index>(i)) = mesh.vertices.row(rim[i]);
    both.spacing[static_cast<Eigen::Index>(i)] =
        edgeLengthNear(mesh, rims, sorted[i < outerSize ? 0 : 1], rim[i]);
    opening.centre += mesh.vertex(rim[i]) / static_cast<double>(n);
  }
  both.joined = [&rims, &rim](int i, int j) { return rims.joined(rim[i], rim[j]); };
  const Lid band = makeBand(both, zip);
  const int first = mesh.addVertices(band.vertices, 1);
  Triangles faces = band.faces;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      int& v = faces(f, k);
      v = v < static_cast<int>(n) ? rim[v] : first + v - static_cast<int>(n);
    }
  mesh.addFaces(faces, 1, mesh.turned[shells->first.faces.front()]);
  opening.edges = static_cast<int>(n);
  opening.perimeter = shells->first.perimeter + shells->second.perimeter;
  opening.newVertices = static_cast<int>(band.vertices.rows());
  opening.newFaces = static_cast<int>(faces.rows());
  return opening;
}

std::vector<Opening> closeOpenings(BrokenMesh& mesh, LidShape shape, const Progress& progress,
                                   std::vector<Opening> openings) {
  Rims rims(mesh);
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
