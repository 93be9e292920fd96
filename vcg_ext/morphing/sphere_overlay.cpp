// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/morphing/sphere_overlay.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "vcg_ext/base/error.h"
#include "vcg_ext/morphing/side_of_arc.h"
#include "vcg_ext/sphere/certificate.h"
#include "vcg_ext/sphere/ray_weights.h"
#include "vcg_ext/sphere/repair/untangling.h"
#include "vcg_ext/sphere/sphere_walk.h"
#include "vcg_ext/sphere/spherical_triangle.h"

namespace sphere_propagation {
namespace {

constexpr double oneMap = 1e-9;
constexpr std::array<double, 4> turnsToTry{0, 1e-6, 1e-5, 1e-4};
/// Of the faces, that rounding may leave flipped without another turn being tried.
constexpr double mendableShare = 1e-3;

/// Thrown where three points lie on one great circle.
struct NotGeneral : std::exception {};

int strictSide(const Vector3& p, const Vector3& q, const Vector3& x) {
  const int side = sideOfArc(p, q, x);
  if (side == 0) throw NotGeneral();
  return side;
}

/// The face under p, strictly. start: where to look first.
int faceUnder(const MappedSurface& map, const Vector3& p, int start) {
  const ClosedSurface& surface = map.surface();
  int face = walkOverSphere(map, p, start);
  for (int step = 0; step <= surface.faceCount(); ++step) {
    int across = -1;
    for (int k = 0; k < 3 && across < 0; ++k) {
      const int h = 3 * face + k;
      if (strictSide(map.position(surface.origin(h)), map.position(surface.target(h)), p) < 0)
        across = surface.twin(h);
    }
    if (across < 0) return face;
    face = across / 3;
  }
  throw NotGeneral();
}

/// The half-edges that the arc from p to q leaves faces by, in order. start: the face under p.
std::vector<int> wayOfArc(const MappedSurface& map, const Vector3& p, const Vector3& q, int start) {
  const ClosedSurface& surface = map.surface();
  const auto sideOf = [&](int v) { return strictSide(p, q, map.position(v)); };
  int out = -1;
  for (int h = 3 * start; h < 3 * start + 3; ++h)
    if (sideOf(surface.origin(h)) < 0 && sideOf(surface.target(h)) > 0) out = h;
  std::vector<int> way;
  while (strictSide(map.position(surface.origin(out)), map.position(surface.target(out)), q) < 0) {
    way.push_back(out);
    const int in = surface.twin(out), next = ClosedSurface::next(in);
    out = sideOf(surface.target(next)) > 0 ? next : ClosedSurface::next(next);
  }
  return way;
}

/// A vertex where half-edge `second` of the second mesh crosses half-edge `first` of the first one
/// from its right to its left.
struct Crossing {
  int first, second;
  int placeOnFirst = 0, placeOnSecond = 0;  ///< in the chains of their edges
};

/// The edges of one mesh, cut at crossings: for each edge the chain of vertices from the origin to
/// the target of the half-edge of the smaller number.
struct Chains {
  explicit Chains(const ClosedSurface& mesh)
      : surface(mesh), of(3 * faces()), offset(3 * faces()) {}
  size_t faces() const { return static_cast<size_t>(surface.faceCount()); }

  bool isLead(int h) const { return h < surface.twin(h); }
  int lead(int h) const { return std::min(h, surface.twin(h)); }
  std::vector<int>& at(int h) { return of[static_cast<size_t>(lead(h))]; }
  const std::vector<int>& at(int h) const { return of[static_cast<size_t>(lead(h))]; }

  const ClosedSurface& surface;
  std::vector<std::vector<int>> of;
  std::vector<int> offset;  ///< number of the first directed piece of the edge
};

/// Two meshes over each other: directed pieces of edges, each with what lies on its left.
class Arrangement {
 public:
  Arrangement(const MappedSurface& first, const MappedSurface& second)
      : maps_{&first, &second}, chains_{Chains(first.surface()), Chains(second.surface())} {
    for (int m = 0; m < 2; ++m) locateVertices(m);
    cross();
  }

  const std::vector<Crossing>& crossings() const { return crossings_; }
  /// For each vertex of mesh m the face of the other one under it.
  const std::vector<int>& under(int m) const { return under_[static_cast<size_t>(m)]; }

  /// The corners of each cell, counter-clockwise.
  std::vector<std::vector<int>> cells() {
    int pieces = 0;
    for (int m = 0; m < 2; ++m)
      for (int h = 0; h < 3 * map(m).surface().faceCount(); ++h)
        if (chains(m).isLead(h)) {
          chains(m).offset[static_cast<size_t>(h)] = pieces;
          pieces += 2 * (static_cast<int>(chains(m).at(h).size()) - 1);
          for (size_t i = 1; i < chains(m).at(h).size(); ++i)
            for (int back = 0; back < 2; ++back)
              pieces_.push_back({m, h, static_cast<int>(i - 1), back == 1});
        }
    std::vector<char> seen(static_cast<size_t>(pieces), 0);
    std::vector<std::vector<int>> found;
    for (int piece = 0; piece < pieces; ++piece) {
      if (seen[static_cast<size_t>(piece)]) continue;
      found.emplace_back();
      for (int at = piece; !seen[static_cast<size_t>(at)]; at = next(at)) {
        seen[static_cast<size_t>(at)] = 1;
        found.back().push_back(tailOf(at));
      }
    }
    return found;
  }

 private:
  struct Piece {
    int mesh, lead, place;
    bool backward;
  };

  const MappedSurface& map(int m) const { return *maps_[static_cast<size_t>(m)]; }
  Chains& chains(int m) { return chains_[static_cast<size_t>(m)]; }
  const Chains& chains(int m) const { return chains_[static_cast<size_t>(m)]; }
  int vertexOf(int m, int v) const { return m == 0 ? v : map(0).vertexCount() + v; }

  void locateVertices(int m) {
    under_[static_cast<size_t>(m)] = facesUnder(map(m), [&](const Vector3& position, int start) {
      return faceUnder(map(1 - m), position, start);
    });
  }

  std::vector<int> wayOf(int m, int h) const {
    const ClosedSurface& surface = map(m).surface();
    const int from = surface.origin(h);
    return wayOfArc(map(1 - m), map(m).position(from), map(m).position(surface.target(h)),
                    under(m)[static_cast<size_t>(from)]);
  }

  void cross() {
    const int vertices = map(0).vertexCount() + map(1).vertexCount();
    const auto number = [&](size_t crossing) { return vertices + static_cast<int>(crossing); };
    for (int m = 0; m < 2; ++m) {
      const ClosedSurface& surface = map(m).surface();
      for (int h = 0; h < 3 * surface.faceCount(); ++h) {
        if (!chains(m).isLead(h)) continue;
        std::vector<int>& chain = chains(m).at(h);
        chain.push_back(vertexOf(m, surface.origin(h)));
        for (const int other : wayOf(m, h)) {
          const int place = static_cast<int>(chain.size());
          if (m == 0) {
            chain.push_back(number(crossings_.size()));
            crossings_.push_back({h, other, place});
          } else {
            const size_t found = crossingOf(other, h, vertices);
            crossings_[found].placeOnSecond = place;
            chain.push_back(number(found));
          }
        }
        chain.push_back(vertexOf(m, surface.target(h)));
      }
    }
  }

  /// The number of the crossing of an edge of the first and one of the second mesh.
  size_t crossingOf(int ofFirst, int ofSecond, int vertices) const {
    for (const int vertex : chains(0).at(ofFirst))
      if (vertex >= vertices) {
        const auto i = static_cast<size_t>(vertex - vertices);
        if (chains(1).lead(crossings_[i].second) == ofSecond) return i;
      }
    throw NotGeneral();  // exact sides rule that out
  }

  int tailOf(int piece) const {
    const Piece& p = pieces_[static_cast<size_t>(piece)];
    return chains(p.mesh).at(p.lead)[static_cast<size_t>(p.place + (p.backward ? 1 : 0))];
  }

  /// The piece of half-edge h of a mesh that leaves the chain's vertex at this place of its lead.
  int pieceFrom(int m, int h, int place) const {
    const Chains& all = chains(m);
    const int first = all.offset[static_cast<size_t>(all.lead(h))];
    return all.isLead(h) ? first + 2 * place : first + 2 * (place - 1) + 1;
  }
  int firstPieceOf(int m, int h) const {
    const Chains& all = chains(m);
    return pieceFrom(m, h, all.isLead(h) ? 0 : static_cast<int>(all.at(h).size()) - 1);
  }

  /// The piece that follows where the cell on the left is gone round.
  int next(int piece) const {
    const Piece& p = pieces_[static_cast<size_t>(piece)];
    const Chains& own = chains(p.mesh);
    const int h = p.backward ? own.surface.twin(p.lead) : p.lead;
    const int place = p.place + (p.backward ? 0 : 1);
    const std::vector<int>& chain = own.at(p.lead);
    if (place == 0 || place + 1 == static_cast<int>(chain.size()))
      return firstPieceOf(p.mesh, ClosedSurface::next(h));
    const int vertices = map(0).vertexCount() + map(1).vertexCount();
    const Crossing& at =
        crossings_[static_cast<size_t>(chain[static_cast<size_t>(place)] - vertices)];
    // To the left: first, second, first back, second back stand counter-clockwise round it.
    const ClosedSurface &a = map(0).surface(), &b = map(1).surface();
    if (p.mesh == 0)
      return pieceFrom(1, h == at.first ? at.second : b.twin(at.second), at.placeOnSecond);
    return pieceFrom(0, h == at.second ? a.twin(at.first) : at.first, at.placeOnFirst);
  }

  std::array<const MappedSurface*, 2> maps_;
  std::array<Chains, 2> chains_;
  std::array<std::vector<int>, 2> under_;
  std::vector<Crossing> crossings_;
  std::vector<Piece> pieces_;
};

/// Where the chord from a to b is met by the plane of an arc: the weight of b.
double shareOnChord(const Vector3& a, const Vector3& b, const Vector3& p, const Vector3& q) {
  const auto height = [&](const Vector3& x) { return std::fabs(x.dot((p - x).cross(q - x))); };
  const double ofA = height(a), ofB = height(b);
  return ofA + ofB > 0 ? ofA / (ofA + ofB) : 0.5;
}

/// Cuts a convex cell into a fan of triangles, from the corner that makes the smallest of them
/// largest.
void addFan(const std::vector<int>& cell, const Points& positions, std::vector<int>& faces) {
  const size_t corners = cell.size();
  const auto at = [&](size_t i) { return cell[i % corners]; };
  const auto place = [&](size_t i) -> Vector3 { return positions.row(at(i)).transpose(); };
  size_t best = 0;
  double most = -std::numeric_limits<double>::infinity();
  for (size_t from = 0; from < (corners == 3 ? 1 : corners); ++from) {
    double least = std::numeric_limits<double>::infinity();
    for (size_t i = 1; i + 1 < corners; ++i)
      least = std::min(least, solidAngle(place(from), place(from + i), place(from + i + 1)));
    if (least > most) {
      most = least;
      best = from;
    }
  }
  for (size_t i = 1; i + 1 < corners; ++i)
    faces.insert(faces.end(), {at(best), at(best + i), at(best + i + 1)});
}

/// Nothing where the maps do not lie in general position, or rounding leaves no valid map.
std::optional<SphereOverlay> overlayAsItIs(const MappedSurface& first,
                                           const MappedSurface& second) {
  Arrangement arrangement(first, second);
  const std::array<const MappedSurface*, 2> maps{&first, &second};
  const std::vector<Crossing>& crossings = arrangement.crossings();
  const int ofFirst = first.vertexCount(), own = ofFirst + second.vertexCount();
  const Eigen::Index count = own + static_cast<Eigen::Index>(crossings.size());
  Points positions(count, 3);
  positions.topRows(ofFirst) = first.positions();
  positions.middleRows(ofFirst, second.vertexCount()) = second.positions();
  std::array<Points, 2> places{Points(count, 3), Points(count, 3)};
  for (int m = 0; m < 2; ++m) {
    const auto k = static_cast<size_t>(m);
    const ClosedSurface &mine = maps[k]->surface(), &others = maps[1 - k]->surface();
    const int begin = m == 0 ? 0 : ofFirst;
    for (int v = 0; v < mine.vertexCount(); ++v) {
      places[k].row(begin + v) = mine.vertices().row(v);
      const int face = arrangement.under(m)[static_cast<size_t>(v)];
      const auto corner = [&](int i) { return maps[1 - k]->position(others.faces()(face, i)); };
      const SurfacePoint point =
          pointOfRay(face, rayWeights(corner(0), corner(1), corner(2), maps[k]->position(v)));
      places[1 - k].row(begin + v) =
          point.interpolate(others.faces(), others.vertices()).transpose();
    }
  }
  for (size_t i = 0; i < crossings.size(); ++i) {
    const Eigen::Index row = own + static_cast<Eigen::Index>(i);
    const std::array<int, 2> halfEdges{crossings[i].first, crossings[i].second};
    std::array<Vector3, 2> from, to;
    for (size_t k = 0; k < 2; ++k) {
      from[k] = maps[k]->position(maps[k]->surface().origin(halfEdges[k]));
      to[k] = maps[k]->position(maps[k]->surface().target(halfEdges[k]));
    }
    for (size_t k = 0; k < 2; ++k) {
      const ClosedSurface& surface = maps[k]->surface();
      const double share = shareOnChord(from[k], to[k], from[1 - k], to[1 - k]);
      const Vector3 a = surface.vertex(surface.origin(halfEdges[k])),
                    b = surface.vertex(surface.target(halfEdges[k]));
      places[k].row(row) = ((1 - share) * a + share * b).transpose();
      if (k == 0)
        positions.row(row) = ((1 - share) * from[k] + share * to[k]).normalized().transpose();
    }
  }
  std::vector<int> corners;
  for (const std::vector<int>& cell : arrangement.cells()) addFan(cell, positions, corners);
  const Triangles faces =
      Eigen::Map<const Triangles>(corners.data(), static_cast<Eigen::Index>(corners.size() / 3), 3);
  ClosedSurface onFirst(std::move(places[0]), faces, first.surface().name());
  ClosedSurface onSecond(std::move(places[1]), faces, second.surface().name());
  std::optional<MappedSurface> map = MappedSurface::ifValid(onFirst, positions);
  if (!map) {
    const Certificate certificate = certify(faces, positions);
    if (static_cast<double>(certificate.flippedFaces) >
        std::max(3.0, mendableShare * static_cast<double>(faces.rows())))
      return std::nullopt;
    try {
      map = untangle(onFirst, std::move(positions)).map;
    } catch (const MapError&) {
      return std::nullopt;
    }
  }
  return SphereOverlay{std::move(*map), std::move(onSecond), static_cast<int>(crossings.size())};
}

bool isOneMap(const MappedSurface& first, const MappedSurface& second) {
  return first.surface().hasFacesOf(second.surface()) &&
         (first.positions() - second.positions()).cwiseAbs().maxCoeff() <= oneMap;
}

}  // namespace

std::optional<SphereOverlay> overlayOnSphere(const MappedSurface& first,
                                             const MappedSurface& second) {
  if (isOneMap(first, second)) return SphereOverlay{first, second.surface()};
  const Vector3 axis = Vector3(0.36, 0.48, 0.8);
  for (const double turn : turnsToTry) {
    try {
      std::optional<MappedSurface> turned = second;
      if (turn > 0) {
        Points positions =
            second.positions() * Eigen::AngleAxisd(turn, axis).toRotationMatrix().transpose();
        positions.rowwise().normalize();
        turned = MappedSurface::ifValid(second.surface(), std::move(positions));
      }
      if (!turned) continue;
      if (std::optional<SphereOverlay> overlay = overlayAsItIs(first, *turned)) {
        overlay->turn = turn;
        return overlay;
      }
    } catch (const NotGeneral&) {
    }
  }
  return std::nullopt;
}

}  // namespace sphere_propagation
