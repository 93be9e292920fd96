// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/preparation/sheets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

namespace sphere_propagation {
namespace {

/// Where the faces round an edge of more than two lie.
struct Blade {
  int halfEdge;
  int sheet;
  bool forward;     // it runs from the smaller vertex to the larger, once its sheet looks outwards
  Vector3 outward;  // unit vector from the edge into the face; zero where that cannot be told
  double angle;     // round the edge, counter-clockwise seen against its direction
};

/// The faces connected through edges with two faces.
class Sheets {
 public:
  explicit Sheets(const BrokenMesh& mesh)
      : mesh_(mesh), edges_(mesh.faces), of_(mesh.faceLid.size(), -1), turned_(of_.size(), 0) {
    for (int f = 0; f < mesh.faceCount(); ++f)
      if (of_[f] < 0) collect(f);
    area_.assign(count_, 0);
    open_.assign(count_, 0);
    for (int f = 0; f < mesh.faceCount(); ++f) {
      area_[of_[f]] += areaVector(mesh.vertices, mesh.faces, f).norm() / 2;
      for (int h = 3 * f; h < 3 * f + 3; ++h)
        if (edges_.size(edges_.edgeOf(h)) == 1) open_[of_[f]] = 1;
    }
    for (int e = 0; e < edges_.count(); ++e)
      if (edges_.size(e) > 2) crowded_.push_back(e);
  }

  const EdgeTable& edges() const { return edges_; }
  const std::vector<int>& crowded() const { return crowded_; }
  int of(int face) const { return of_[face]; }
  int count() const { return count_; }
  double area(int sheet) const { return area_[sheet]; }
  bool isOpen(int sheet) const { return open_[sheet] != 0; }

  std::vector<Blade> bladesAt(int edge) const {
    std::vector<Blade> blades;
    const int first = edges_.halfEdge(edge, 0);
    const auto ends = endsOf(first);
    const Vector3 from = mesh_.vertex(std::min(ends[0], ends[1])),
                  to = mesh_.vertex(std::max(ends[0], ends[1]));
    const Vector3 axis = (to - from).stableNormalized();
    Vector3 x = Vector3::Zero(), y = x;
    for (int i = 0; i < edges_.size(edge); ++i) {
      const int h = edges_.halfEdge(edge, i), f = h / 3;
      Vector3 out = mesh_.vertex(mesh_.faces(f, (h + 2) % 3)) - from;
      out -= axis * axis.dot(out);
      out = out.stableNormalized();
      if (x.isZero()) {
        x = out;
        y = axis.cross(x);
      }
      const bool forward = (endsOf(h)[0] < endsOf(h)[1]) != (turned_[f] != 0);
      blades.push_back({h, of_[f], forward, out, std::atan2(y.dot(out), x.dot(out))});
    }
    return blades;
  }

 private:
  std::array<int, 2> endsOf(int h) const {
    return {mesh_.faces(h / 3, h % 3), mesh_.faces(h / 3, (h + 1) % 3)};
  }

  /// Finds a sheet and turns its faces alike, as far as it has two sides; outwards, should it close
  /// (nearly).
  void collect(int seed) {
    std::vector<int> members{seed};
    of_[seed] = count_;
    for (size_t i = 0; i < members.size(); ++i) {
      const int f = members[i];
      for (int h = 3 * f; h < 3 * f + 3; ++h) {
        const int g = edges_.twin(h);
        if (g < 0 || of_[g / 3] >= 0) continue;
        of_[g / 3] = count_;
        turned_[g / 3] = (endsOf(h)[0] == endsOf(g)[0]) != (turned_[f] != 0);
        members.push_back(g / 3);
      }
    }
    Vector3 centre = Vector3::Zero();
    double weight = 0;
    for (const int f : members) {
      const double a = areaVector(mesh_.vertices, mesh_.faces, f).norm();
      for (int k = 0; k < 3; ++k) centre += a * mesh_.vertex(mesh_.faces(f, k));
      weight += 3 * a;
    }
    if (weight > 0) centre /= weight;
    double volume = 0;
    for (const int f : members)
      volume +=
          (turned_[f] ? -1 : 1) *
          areaVector(mesh_.vertices, mesh_.faces, f).dot(mesh_.vertex(mesh_.faces(f, 0)) - centre);
    if (volume < 0)
      for (const int f : members) turned_[f] = !turned_[f];
    ++count_;
  }

  const BrokenMesh& mesh_;
  EdgeTable edges_;
  std::vector<int> of_;
  std::vector<char> turned_;
  int count_ = 0;
  std::vector<double> area_;
  std::vector<char> open_;
  std::vector<int> crowded_;
};

int countOf(const std::vector<Blade>& blades, int sheet) {
  return static_cast<int>(std::count_if(blades.begin(), blades.end(),
                                        [sheet](const Blade& b) { return b.sheet == sheet; }));
}

/// Drops the cheapest sheets where sheets meet in an odd way; those that have a cheaper one beside
/// them wait for the next round. Returns how many faces were dropped.
int dropCheapestSheets(BrokenMesh& mesh) {
  const Sheets sheets(mesh);
  if (sheets.crowded().empty()) return 0;
  const size_t count = static_cast<size_t>(sheets.count());
  std::vector<char> odd(count, 0), needed(count, 0);
  std::vector<double> length(count, 0), crossLength(count, 0);
  double total = 0;
  for (int s = 0; s < sheets.count(); ++s) total += sheets.area(s);
  for (const int e : sheets.crowded()) {
    const std::vector<Blade> blades = sheets.bladesAt(e);
    const int h = blades[0].halfEdge;
    const double edgeLength =
        (mesh.vertex(mesh.faces(h / 3, h % 3)) - mesh.vertex(mesh.faces(h / 3, (h + 1) % 3)))
            .norm();
    size_t one = 0, other = 1;
    double flattest = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < blades.size(); ++i)
      for (size_t j = i + 1; j < blades.size(); ++j)
        if (const double cosine = blades[i].outward.dot(blades[j].outward); cosine < flattest)
          flattest = cosine, one = i, other = j;
    for (size_t i = 0; i < blades.size(); ++i) {
      const int s = blades[i].sheet, here = countOf(blades, s);
      if (here % 2 == 1) odd[s] = 1;
      if (static_cast<int>(blades.size()) - here == 1) needed[s] = 1;
      length[s] += edgeLength;
      if (i != one && i != other) crossLength[s] += edgeLength;
    }
  }
  constexpr double smoothlyOn = 10, ending = 0.25;
  std::vector<double> cost(count, std::numeric_limits<double>::infinity());
  for (int s = 0; s < sheets.count(); ++s)
    if (odd[s] && !needed[s] && sheets.area(s) < 0.5 * total)
      cost[s] = sheets.area(s) * (2 * crossLength[s] > length[s] ? 1 : smoothlyOn) *
                (sheets.isOpen(s) ? ending : 1);
  std::vector<char> waits(count, 0);
  const auto dearer = [&](int a, int b) {
    return std::make_tuple(cost[a], a) > std::make_tuple(cost[b], b);
  };
  for (const int e : sheets.crowded()) {
    const std::vector<Blade> blades = sheets.bladesAt(e);
    for (const Blade& a : blades)
      for (const Blade& b : blades)
        if (a.sheet != b.sheet && dearer(a.sheet, b.sheet)) waits[a.sheet] = 1;
  }
  std::vector<char> keep(mesh.faceLid.size());
  for (int f = 0; f < mesh.faceCount(); ++f)
    keep[f] = std::isinf(cost[sheets.of(f)]) || waits[sheets.of(f)];
  return mesh.keepFaces(keep);
}

/// Pairs the faces round an edge. Returns the half-edges of each pair.
std::vector<std::array<int, 2>> paired(const std::vector<Blade>& blades) {
  struct Pair {
    int ofDifferentSheets, alike;
    double opening;
    size_t one, other;
    bool operator<(const Pair& o) const {
      return std::tie(ofDifferentSheets, alike, opening, one, other) <
             std::tie(o.ofDifferentSheets, o.alike, o.opening, o.one, o.other);
    }
  };
  const auto forward =
      std::count_if(blades.begin(), blades.end(), [](const Blade& b) { return b.forward; });
  const bool balanced = 2 * static_cast<size_t>(forward) == blades.size();
  std::vector<Pair> pairs;
  for (size_t i = 0; i < blades.size(); ++i)
    for (size_t j = i + 1; j < blades.size(); ++j) {
      const Blade &a = blades[i], &b = blades[j];
      const bool ofOneSheet = a.sheet == b.sheet && countOf(blades, a.sheet) == 2;
      double opening = a.outward.dot(b.outward);  // the flattest
      if (balanced) {  // the smallest inside, which lies clockwise of a face that runs forward
        opening = a.forward ? a.angle - b.angle : b.angle - a.angle;
        if (opening < 0) opening += 2 * pi;
      }
      pairs.push_back({!ofOneSheet, a.forward == b.forward, opening, i, j});
    }
  std::sort(pairs.begin(), pairs.end());
  std::vector<char> taken(blades.size(), 0);
  std::vector<std::array<int, 2>> result;
  for (const Pair& p : pairs) {
    if (taken[p.one] || taken[p.other]) continue;
    taken[p.one] = taken[p.other] = 1;
    result.push_back({blades[p.one].halfEdge, blades[p.other].halfEdge});
  }
  return result;
}

/// Copies vertices such that each has one fan of faces, which hang together through pairs.
long copyVertices(BrokenMesh& mesh, const std::vector<int>& mate) {
  DisjointSets corners(3 * mesh.faceCount());
  const auto next = [](int h) { return h % 3 == 2 ? h - 2 : h + 1; };
  for (int h = 0; h < 3 * mesh.faceCount(); ++h) {
    const int g = mate[h];
    if (g < h) continue;  // none, or looked at
    const bool opposite = mesh.faces(h / 3, h % 3) != mesh.faces(g / 3, g % 3);
    corners.unite(h, opposite ? next(g) : g);
    corners.unite(next(h), opposite ? g : next(g));
  }
  std::vector<char> met(mesh.source.size(), 0);
  std::vector<int> vertexOf(3 * mesh.faceLid.size(), -1), originals;
  for (int h = 0; h < 3 * mesh.faceCount(); ++h) {
    const int v = mesh.faces(h / 3, h % 3);
    if (corners.find(h) != h) continue;
    if (!met[v]) {
      vertexOf[h] = v;
    } else {
      vertexOf[h] = mesh.vertexCount() + static_cast<int>(originals.size());
      originals.push_back(v);
    }
    met[v] = 1;
  }
  for (int h = 0; h < 3 * mesh.faceCount(); ++h)
    mesh.faces(h / 3, h % 3) = vertexOf[corners.find(h)];
  mesh.addCopiesOf(originals);
  return static_cast<long>(originals.size());
}

/// Splits an edge of some faces at its middle.
void splitEdge(BrokenMesh& mesh, const std::vector<int>& halfEdges) {
  const int h = halfEdges[0];
  const int middle = mesh.addVertices(0.5 * (mesh.vertices.row(mesh.faces(h / 3, h % 3)) +
                                             mesh.vertices.row(mesh.faces(h / 3, (h + 1) % 3))),
                                      0);
  for (const int g : halfEdges) {
    const int f = g / 3, k = g % 3;
    Triangles half(1, 3);
    half << middle, mesh.faces(f, (k + 1) % 3), mesh.faces(f, (k + 2) % 3);
    mesh.addFaces(half, mesh.faceLid[f], mesh.turned[f]);
    mesh.faces(f, (k + 1) % 3) = middle;
  }
}

/// Cuts at the edges with more than two faces. Returns how many vertices were added.
long cut(BrokenMesh& mesh) {
  std::vector<int> mate(3 * mesh.faceLid.size(), -1);
  {
    const Sheets sheets(mesh);
    const EdgeTable& edges = sheets.edges();
    for (int h = 0; h < 3 * mesh.faceCount(); ++h) mate[h] = edges.twin(h);
    for (const int e : sheets.crowded())
      for (const auto& [h, g] : paired(sheets.bladesAt(e))) {
        mate[h] = g;
        mate[g] = h;
      }
  }
  long added = copyVertices(mesh, mate);
  // The ends of an edge may have stayed together.
  const EdgeTable edges(mesh.faces);
  std::vector<char> touched(mesh.faceLid.size(), 0);
  for (int e = 0; e < edges.count(); ++e) {
    if (edges.size(e) <= 2) continue;
    std::vector<std::vector<int>> groups;
    for (int i = 0; i < edges.size(e); ++i) {
      const int h = edges.halfEdge(e, i), g = mate[h];
      if (g >= 0 && g < h) continue;
      groups.push_back(g < 0 ? std::vector<int>{h} : std::vector<int>{h, g});
    }
    for (size_t i = 1; i < groups.size(); ++i) {
      const bool free = std::none_of(groups[i].begin(), groups[i].end(),
                                     [&](int h) { return touched[h / 3] != 0; });
      if (!free) continue;
      for (const int h : groups[i]) touched[h / 3] = 1;
      splitEdge(mesh, groups[i]);
      ++added;
    }
  }
  return added;
}

}  // namespace

SeparatedSheets separateSheets(BrokenMesh& mesh) {
  SeparatedSheets result;
  const double area = areaOf(mesh);
  {
    const EdgeTable edges(mesh.faces);
    for (int e = 0; e < edges.count(); ++e) result.edges += edges.size(e) > 2;
  }
  while (const int dropped = dropCheapestSheets(mesh)) result.droppedFaces += dropped;
  if (result.droppedFaces > 0 && area > 0) result.droppedShare = 1 - areaOf(mesh) / area;
  constexpr int rounds = 50;
  for (int i = 0; i < rounds; ++i) {
    const long added = cut(mesh);
    if (result.edges == 0) result.vertices += added;
    result.splitVertices += added;
    if (added == 0) break;
  }
  return result;
}

}  // namespace sphere_propagation
