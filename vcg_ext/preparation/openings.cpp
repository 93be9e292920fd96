// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/preparation/openings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
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
    std::vector<int> all;
    for (int h = 0; h < 3 * mesh_.faceCount(); ++h)
      if (edges.size(edges.edgeOf(h)) == 1) all.push_back(h);
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
        h = following(edges, h);
      }
      if (h == start) split(ring, one);
    }
    for (int h = 0; h < 3 * mesh_.faceCount(); ++h)
      mesh_.faces(h / 3, h % 3) = nowOf(one, origin(h));
  }

  /// The next half-edge of a rim: at its end, round the faces of its own fan; -1: none.
  int following(const EdgeTable& edges, int h) const {
    const auto next = [](int i) { return i - i % 3 + (i + 1) % 3; };
    h = next(h);
    for (int steps = 0; edges.size(edges.edgeOf(h)) != 1; ++steps) {
      const int twin = edges.twin(h);
      if (twin < 0 || origin(twin) == origin(h) || steps > mesh_.faceCount()) return -1;
      h = next(twin);
    }
    return h;
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

/// Where a shell is open.
struct ShellRim {
  Ring ring;
  std::vector<int> points;  // origins along the ring
  double perimeter = 0;
  Vector3 normal = Vector3::Zero();  // by the right hand along the ring
  Vector3 centre = Vector3::Zero();
};

/// One side of a wall.
struct Shell {
  std::vector<int> faces;
  std::vector<ShellRim> rims;
  double volume = 0;  // six times it, with a fan on each rim: positive where faces look outwards
};

ShellRim shellRimOf(const BrokenMesh& mesh, const Rims& rims, const Ring& ring) {
  ShellRim rim;
  rim.ring = ring;
  for (const int h : ring) {
    rim.points.push_back(rims.origin(h));
    rim.perimeter += (mesh.vertex(rims.target(h)) - mesh.vertex(rims.origin(h))).norm();
    rim.centre += mesh.vertex(rims.origin(h)) / static_cast<double>(ring.size());
  }
  for (const int h : ring)
    rim.normal +=
        (mesh.vertex(rims.origin(h)) - rim.centre).cross(mesh.vertex(rims.target(h)) - rim.centre);
  return rim;
}

void measureVolume(const BrokenMesh& mesh, Shell& shell) {
  const Vector3 origin = shell.rims.front().centre;
  for (const int f : shell.faces)
    shell.volume +=
        areaVector(mesh.vertices, mesh.faces, f).dot(mesh.vertex(mesh.faces(f, 0)) - origin);
  // The fan runs the other way round.
  for (const ShellRim& rim : shell.rims) shell.volume -= rim.normal.dot(rim.centre - origin);
}

/// How often a shell with the fans on its rims goes round a point; near 1 or -1 inside.
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
  for (const ShellRim& rim : shell.rims)
    for (size_t i = 0; i < rim.points.size(); ++i)
      sum += angle(rim.centre - point, mesh.vertex(rim.points[(i + 1) % rim.points.size()]) - point,
                   mesh.vertex(rim.points[i]) - point);
  return sum / (4 * pi);
}

/// Whether most of one shell lies inside another.
bool liesIn(const BrokenMesh& mesh, const Shell& inner, const Shell& outer) {
  constexpr double mostly = 0.9;
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

/// The large parts of a mesh that are open, the one that holds most first.
std::vector<Shell> largeShells(const BrokenMesh& mesh, const Rims& rims) {
  constexpr double smallest = 0.1;
  const EdgeTable edges(mesh.faces);
  DisjointSets sets(mesh.faceCount());
  for (int e = 0; e < edges.count(); ++e)
    for (int i = 1; i < edges.size(e); ++i)
      sets.unite(edges.halfEdge(e, 0) / 3, edges.halfEdge(e, i) / 3);
  std::vector<double> area(mesh.faceLid.size(), 0);
  for (int f = 0; f < mesh.faceCount(); ++f)
    area[sets.find(f)] += areaVector(mesh.vertices, mesh.faces, f).norm();
  const double most = area.empty() ? 0 : *std::max_element(area.begin(), area.end());
  std::vector<int> shellOf(area.size(), -1);
  std::vector<Shell> shells;
  for (int f = 0; f < mesh.faceCount(); ++f)
    if (area[f] > 0 && area[f] >= smallest * most) {
      shellOf[f] = static_cast<int>(shells.size());
      shells.emplace_back();
    }
  for (int f = 0; f < mesh.faceCount(); ++f)
    if (const int s = shellOf[sets.find(f)]; s >= 0) shells[s].faces.push_back(f);
  for (const Ring& ring : rims.rings()) {
    const int s = shellOf[sets.find(ring.front() / 3)];
    if (s >= 0 && ring.size() >= 3) shells[s].rims.push_back(shellRimOf(mesh, rims, ring));
  }
  shells.erase(std::remove_if(shells.begin(), shells.end(),
                              [](const Shell& shell) { return shell.rims.empty(); }),
               shells.end());
  for (Shell& shell : shells) measureVolume(mesh, shell);
  std::stable_sort(shells.begin(), shells.end(), [](const Shell& a, const Shell& b) {
    return std::fabs(a.volume) > std::fabs(b.volume);
  });
  return shells;
}

/// How far the points of one rim lie from those of another at most.
double farthestFrom(const BrokenMesh& mesh, const ShellRim& rim, const ShellRim& other) {
  double farthest = 0;
  for (const int v : rim.points) {
    double nearest = HUGE_VAL;
    for (const int w : other.points)
      nearest = std::min(nearest, (mesh.vertex(v) - mesh.vertex(w)).norm());
    farthest = std::max(farthest, nearest);
  }
  return farthest;
}

/// The distance between a shell and the one round it: the median from some of its vertices.
double thicknessOf(const BrokenMesh& mesh, const Shell& outer, const Shell& inner) {
  constexpr size_t samples = 64;
  std::vector<double> distances;
  for (size_t i = 0; i < inner.faces.size();
       i += std::max<size_t>(1, inner.faces.size() / samples)) {
    double nearest = HUGE_VAL;
    for (const int f : outer.faces)
      nearest = std::min(
          nearest, (mesh.vertex(mesh.faces(f, 0)) - mesh.vertex(mesh.faces(inner.faces[i], 0)))
                       .squaredNorm());
    distances.push_back(std::sqrt(nearest));
  }
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

/// The rim of the outer shell beside which one of the inner shell lies, -1: none. What lies within
/// a round rim is no farther from it than its radius; small ones lie on both sides of a wall.
int rimBeside(const BrokenMesh& mesh, const Shell& outer, const Shell& inner, const ShellRim& rim,
              double thickness) {
  constexpr double alike = 0.7, narrowest = 0.3, farthest = 2;  // thicknesses
  int found = -1;
  double nearest = HUGE_VAL;
  for (size_t o = 0; o < outer.rims.size(); ++o) {
    const ShellRim& other = outer.rims[o];
    if (rim.perimeter < narrowest * other.perimeter) continue;
    const double cosine = rim.normal.stableNormalized().dot(other.normal.stableNormalized());
    if ((outer.volume > 0) == (inner.volume > 0) ? cosine < alike : cosine > -alike) continue;
    const double distance = farthestFrom(mesh, rim, other);
    if (distance > std::max(other.perimeter / (2 * pi), farthest * thickness)) continue;
    if (distance >= nearest) continue;
    nearest = distance;
    found = static_cast<int>(o);
  }
  return found;
}

/// The sides of a wall, and where they are to be joined.
struct Wall {
  Shell outer;
  std::vector<Shell> inner;
  std::vector<int> outerRim, innerRim;  // of each inner shell, the rims to be joined
  std::vector<double> thickness;        // of each, thicknessOf
};

/// Each inner shell is joined to the outer one once, at its longest rim that can be: that leaves no
/// handle.
std::optional<Wall> wallRound(const BrokenMesh& mesh, const std::vector<Shell>& shells, size_t o) {
  Wall wall{shells[o], {}, {}, {}, {}};
  for (size_t i = 0; i < shells.size(); ++i) {
    if (i == o) continue;
    const Shell& inner = shells[i];
    const double thickness = thicknessOf(mesh, wall.outer, inner);
    int best = -1, beside = -1;
    for (size_t r = 0; r < inner.rims.size(); ++r) {
      if (best >= 0 && inner.rims[r].perimeter <= inner.rims[best].perimeter) continue;
      const int found = rimBeside(mesh, wall.outer, inner, inner.rims[r], thickness);
      if (found < 0) continue;
      best = static_cast<int>(r);
      beside = found;
    }
    const auto holdsIt = [&](const Shell& other) { return liesIn(mesh, inner, other); };
    if (best < 0 || !holdsIt(wall.outer) ||
        std::any_of(wall.inner.begin(), wall.inner.end(), holdsIt))
      continue;
    wall.inner.push_back(inner);
    wall.outerRim.push_back(beside);
    wall.innerRim.push_back(best);
    wall.thickness.push_back(thickness);
  }
  if (wall.inner.empty()) return std::nullopt;
  return wall;
}

std::optional<Wall> wallOf(const BrokenMesh& mesh, const Rims& rims) {
  const std::vector<Shell> shells = largeShells(mesh, rims);
  for (size_t o = 0; o < shells.size(); ++o)
    if (auto wall = wallRound(mesh, shells, o)) return wall;
  return std::nullopt;
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

/// Faces between one rim and several within it, as indices into all, one behind the other; they run
/// as those of `zipped`. The rims are joined to one polygon by the shortest lines between them.
/// Empty where that leaves no triangulation.
Triangles spanned(const BrokenMesh& mesh, const std::vector<std::vector<int>>& rims, const Rim& all,
                  const std::function<bool(int, int)>& joined) {
  std::vector<std::vector<int>> holes;
  std::vector<int> vertices;
  for (const std::vector<int>& rim : rims) {
    holes.emplace_back();
    for (const int v : rim) {
      holes.back().push_back(static_cast<int>(vertices.size()));
      vertices.push_back(v);
    }
  }
  std::vector<int> polygon = holes.front();
  std::reverse(polygon.begin(), polygon.end());
  holes.erase(holes.begin());
  std::vector<std::pair<int, int>> bridges;
  while (!holes.empty()) {
    size_t hole = 0;
    std::ptrdiff_t from = 0, to = 0;
    double nearest = HUGE_VAL;
    for (size_t h = 0; h < holes.size(); ++h)
      for (size_t i = 0; i < polygon.size(); ++i)
        for (size_t j = 0; j < holes[h].size(); ++j)
          if (const double d =
                  (mesh.vertex(vertices[polygon[i]]) - mesh.vertex(vertices[holes[h][j]]))
                      .squaredNorm();
              d < nearest) {
            nearest = d;
            hole = h;
            from = static_cast<std::ptrdiff_t>(i);
            to = static_cast<std::ptrdiff_t>(j);
          }
    std::vector<int> round = holes[hole];
    std::rotate(round.begin(), round.begin() + to, round.end());
    round.push_back(round.front());
    const int bridge = polygon[static_cast<size_t>(from)];
    bridges.emplace_back(bridge, round.front());
    round.push_back(bridge);
    polygon.insert(polygon.begin() + from + 1, round.begin(), round.end());
    holes.erase(holes.begin() + static_cast<std::ptrdiff_t>(hole));
  }
  Rim rim = all;
  rim.joined = [&](int i, int j) {
    const auto isBridge = [&](const std::pair<int, int>& b) {
      return b == std::pair(i, j) || b == std::pair(j, i);
    };
    return i == j || joined(i, j) || std::any_of(bridges.begin(), bridges.end(), isBridge);
  };
  return polygonFaces(rim, polygon);
}

/// Puts a ring between one rim of the outer shell and those of inner shells beside it. Nothing
/// where there is none.
std::optional<Opening> joinRims(BrokenMesh& mesh, Rims& rims, const ShellRim& outer,
                                const std::vector<const ShellRim*>& inner, int number) {
  std::vector<std::vector<int>> parts{outer.points};
  double perimeter = outer.perimeter;
  for (const ShellRim* rim : inner) {
    parts.emplace_back(rim->points.rbegin(), rim->points.rend());
    perimeter += rim->perimeter;
  }
  std::vector<int> rim;
  for (const std::vector<int>& part : parts) rim.insert(rim.end(), part.begin(), part.end());
  const auto n = static_cast<Eigen::Index>(rim.size());
  Rim all{Points(n, 3), Points::Zero(n, 3), Eigen::VectorXd(n), Points::Zero(n, 3), {}};
  Opening opening;
  Eigen::Index row = 0;
  for (const std::vector<int>& part : parts) {
    std::vector<int> sorted = part;
    std::sort(sorted.begin(), sorted.end());
    for (const int v : part) {
      all.points.row(row) = mesh.vertices.row(v);
      all.spacing[row++] = edgeLengthNear(mesh, rims, sorted, v);
      opening.centre += mesh.vertex(v) / static_cast<double>(n);
    }
  }
  all.joined = [&rims, &rim](int i, int j) { return rims.joined(rim[i], rim[j]); };
  const Triangles between =
      parts.size() == 2 ? zipped(mesh, parts[0], parts[1]) : spanned(mesh, parts, all, all.joined);
  if (between.rows() == 0) return std::nullopt;
  const Lid band = makeBand(all, between);
  const int first = mesh.addVertices(band.vertices, number);
  rims.addVertices(static_cast<size_t>(band.vertices.rows()));
  Triangles faces = band.faces;
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      int& v = faces(f, k);
      v = v < static_cast<int>(n) ? rim[v] : first + v - static_cast<int>(n);
    }
    for (int k = 0; k < 3; ++k) rims.join(faces(f, k), faces(f, (k + 1) % 3));
  }
  mesh.addFaces(faces, number, mesh.turned[outer.ring.front() / 3]);
  opening.edges = static_cast<int>(n);
  opening.perimeter = perimeter;
  opening.newVertices = static_cast<int>(band.vertices.rows());
  opening.newFaces = static_cast<int>(faces.rows());
  return opening;
}

/// The convex hull of the rim (A. M. Andrew's chains, 1979), seen along the normal of its area.
void measureOutline(Opening& opening, const BrokenMesh& mesh, const std::vector<int>& rim) {
  Vector3 normal = Vector3::Zero();
  const auto place = [&](size_t i) -> Vector3 {
    return mesh.vertex(rim[i % rim.size()]) - opening.centre;
  };
  for (size_t i = 0; i < rim.size(); ++i) normal += place(i).cross(place(i + 1));
  if (!(normal.norm() > 0)) return;
  normal.normalize();
  const Vector3 u = normal.unitOrthogonal(), w = normal.cross(u);
  using Place = std::pair<double, double>;
  std::vector<Place> places;
  double highest = 0;
  for (size_t i = 0; i < rim.size(); ++i) {
    places.emplace_back(u.dot(place(i)), w.dot(place(i)));
    highest = std::max(highest, std::fabs(normal.dot(place(i))));
  }
  std::sort(places.begin(), places.end());
  std::vector<Place> hull;
  for (int side = 0; side < 2; ++side) {
    const size_t first = hull.size();
    for (const Place& p : places) {
      const auto turnsRight = [&] {
        const Place &a = hull[hull.size() - 2], &b = hull.back();
        return (b.first - a.first) * (p.second - a.second) <=
               (b.second - a.second) * (p.first - a.first);
      };
      while (hull.size() >= first + 2 && turnsRight()) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(places.begin(), places.end());
  }
  for (size_t i = 0; i < hull.size(); ++i) {
    const Place &a = hull[i], &b = hull[(i + 1) % hull.size()];
    opening.outline += std::hypot(b.first - a.first, b.second - a.second);
  }
  if (opening.outline > 0) opening.relief = highest / (opening.outline / (2 * pi));
}

}  // namespace

bool hasShells(const BrokenMesh& mesh) {
  BrokenMesh copy = mesh;
  orientAlike(copy);
  const Rims rims(copy);
  return wallOf(copy, rims).has_value();
}

JoinedShells joinShells(BrokenMesh& mesh) {
  orientAlike(mesh);
  {
    BrokenMesh copy = mesh;
    const Rims rims(copy);
    const auto wall = wallOf(copy, rims);
    if (!wall) return {};
    const auto turn = [&](const Shell& shell) {
      for (const int f : shell.faces) turnFace(mesh, f);
    };
    if (wall->outer.volume < 0) turn(wall->outer);
    for (const Shell& inner : wall->inner)
      if (inner.volume > 0) turn(inner);
  }
  Rims rims(mesh);
  const auto wall = wallOf(mesh, rims);
  if (!wall) return {};
  JoinedShells joined;
  for (size_t o = 0; o < wall->outer.rims.size(); ++o) {
    std::vector<const ShellRim*> beside;
    for (size_t i = 0; i < wall->inner.size(); ++i)
      if (wall->outerRim[i] == static_cast<int>(o))
        beside.push_back(&wall->inner[i].rims[wall->innerRim[i]]);
    if (beside.empty()) continue;
    const auto number = static_cast<int>(joined.rings.size()) + 1;
    auto ring = joinRims(mesh, rims, wall->outer.rims[o], beside, number);
    if (!ring) {
      beside = {beside.front()};
      ring = joinRims(mesh, rims, wall->outer.rims[o], beside, number);
    }
    joined.rings.push_back(*ring);
    joined.shells += static_cast<int>(beside.size());
    for (size_t i = 0; i < wall->inner.size(); ++i)
      for (const ShellRim& rim : wall->inner[i].rims) {
        const bool isJoined = std::any_of(beside.begin(), beside.end(),
                                          [&](const ShellRim* other) { return other == &rim; });
        if (!isJoined && rimBeside(mesh, wall->outer, wall->inner[i], rim, wall->thickness[i]) ==
                             static_cast<int>(o))
          joined.covered.push_back(rim.centre);
      }
  }
  return joined;
}

bool isRagged(const Opening& opening) {
  constexpr int enoughEdges = 20;
  constexpr double longer = 1.4, deep = 0.1;
  return opening.edges >= enoughEdges && opening.perimeter > longer * opening.outline &&
         opening.relief > deep;
}

std::vector<Opening> closeOpenings(BrokenMesh& mesh, LidShape shape, const Progress& progress,
                                   const JoinedShells& joined) {
  constexpr double nearby = 0.02;  // of the perimeter
  std::vector<Opening> openings = joined.rings;
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
    measureOutline(opening, mesh, rim);
    if (ring.size() == 3 && ring[0] / 3 == ring[1] / 3 && ring[1] / 3 == ring[2] / 3) continue;
    const bool isCovered =
        std::any_of(joined.covered.begin(), joined.covered.end(), [&](const Vector3& centre) {
          return (centre - opening.centre).norm() < nearby * opening.perimeter;
        });
    const LidShape own = isCovered ? LidShape::Flat : shape;
    opening.shape = own;
    const Lid lid = makeLid(rimOf(mesh, rims, ring, rim, own), own);
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
