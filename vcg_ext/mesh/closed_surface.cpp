// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/closed_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

namespace sphere_propagation {
namespace {

/// How many elements have a defect, and which is the first.
struct Tally {
  long count = 0;
  long first = -1;
  void add(long index) {
    if (count++ == 0 || index < first) first = index;
  }
};

[[noreturn]] void fail(const std::string& name, Fault fault, const Tally& tally) {
  throw SurfaceError(Finding(fault, name).of(tally.count, tally.first));
}

/// Vertices that lie exactly where another one lies: what is left of a mesh whose faces were stored
/// one by one.
long coincidentVertices(const Points& vertices) {
  std::vector<int> order(static_cast<size_t>(vertices.rows()));
  std::iota(order.begin(), order.end(), 0);
  const auto row = [&](int v) {
    return std::make_tuple(vertices(v, 0), vertices(v, 1), vertices(v, 2));
  };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return row(a) < row(b); });
  long count = 0;
  for (size_t i = 1; i < order.size(); ++i) count += row(order[i]) == row(order[i - 1]);
  return count;
}

void requireFinite(const Points& vertices, const std::string& name) {
  Tally bad;
  for (Eigen::Index v = 0; v < vertices.rows(); ++v)
    if (!vertices.row(v).allFinite()) bad.add(v);
  if (bad.count > 0) fail(name, Fault::NonFiniteCoordinate, bad);
}

struct Openings {
  long count = 0;
  long edgesOfLargest = 0;
};

/// Checks a mesh step by step, and finds out how it hangs together on the way.
class Inspection {
 public:
  Inspection(const Points& vertices, Connectivity& mesh, const std::string& name)
      : vertices_(vertices),
        faces_(mesh.faces),
        name_(name),
        mesh_(mesh),
        twin_(mesh.twin),
        offset_(mesh.offset),
        outgoing_(mesh.outgoing),
        ring_(mesh.neighbours) {}

  void run() {
    checkElements();
    connectEdges();
    connectVertices();
    checkTopology();
  }

 private:
  void checkElements() const;
  void connectEdges();
  void connectVertices();
  void checkTopology() const;
  Openings openings() const;
  int vertexCount() const { return static_cast<int>(vertices_.rows()); }
  int faceCount() const { return static_cast<int>(faces_.rows()); }
  int origin(int h) const { return mesh_.origin(h); }
  int target(int h) const { return mesh_.target(h); }
  static int previous(int h) { return Connectivity::previous(h); }
  IndexRange ring(int v) const {
    return {ring_.data() + offset_[v], ring_.data() + offset_[v + 1]};
  }

  const Points& vertices_;
  const Triangles& faces_;
  const std::string& name_;
  Connectivity& mesh_;
  std::vector<int>&twin_, &offset_, &outgoing_, &ring_;
};

void Inspection::checkElements() const {
  const int n = vertexCount(), m = faceCount();
  if (m == 0) fail(name_, n == 0 ? Fault::Empty : Fault::NoFaces, {});
  if (n < 4) fail(name_, Fault::TooFewVertices, {n, 0});
  requireFinite(vertices_, name_);
  Tally bad;
  for (int f = 0; f < m; ++f)
    if (faces_.row(f).minCoeff() < 0 || faces_.row(f).maxCoeff() >= n) bad.add(f);
  if (bad.count > 0) fail(name_, Fault::IndexOutOfRange, bad);
  for (int f = 0; f < m; ++f)
    if (faces_(f, 0) == faces_(f, 1) || faces_(f, 1) == faces_(f, 2) ||
        faces_(f, 2) == faces_(f, 0))
      bad.add(f);
  if (bad.count > 0) fail(name_, Fault::DegenerateFace, bad);
}

void Inspection::connectEdges() {
  // The half-edges, sorted into buckets by their smaller vertex and there by the larger: those of
  // one edge meet.
  struct Entry {
    int larger, halfEdge;
    bool operator<(const Entry& o) const {
      return std::tie(larger, halfEdge) < std::tie(o.larger, o.halfEdge);
    }
  };
  const int n = vertexCount(), halfEdges = 3 * faceCount();
  std::vector<int> start(static_cast<size_t>(n) + 1, 0);
  for (int h = 0; h < halfEdges; ++h)
    ++start[static_cast<size_t>(std::min(origin(h), target(h))) + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<Entry> entries(static_cast<size_t>(halfEdges));
  {
    std::vector<int> fill(start.begin(), start.end() - 1);
    for (int h = 0; h < halfEdges; ++h)
      entries[fill[std::min(origin(h), target(h))]++] = {std::max(origin(h), target(h)), h};
  }
  twin_.assign(static_cast<size_t>(halfEdges), -1);
  Tally crowded, open, opposed;
  for (int v = 0; v < n; ++v) {
    std::sort(entries.begin() + start[v], entries.begin() + start[v + 1]);
    for (int i = start[v], j = i; i < start[v + 1]; i = j) {
      while (j < start[v + 1] && entries[j].larger == entries[i].larger) ++j;
      const int a = entries[i].halfEdge;
      if (j - i == 1) {
        open.add(a / 3);
      } else if (j - i > 2) {
        crowded.add(a / 3);
      } else {
        const int b = entries[i + 1].halfEdge;
        if (origin(a) == origin(b)) opposed.add(a / 3);
        twin_[a] = b;
        twin_[b] = a;
      }
    }
  }
  if (crowded.count > 0) fail(name_, Fault::NonManifoldEdge, crowded);
  if (open.count > 0) {
    const long coincident = coincidentVertices(vertices_);
    if (coincident > 0)
      throw SurfaceError(
          Finding(Fault::NotWelded, name_).of(open.count, open.first).amid(coincident));
    const Openings around = openings();
    const auto edges = static_cast<double>(around.edgesOfLargest);
    throw SurfaceError(Finding(Fault::NotClosed, name_)
                           .of(open.count, open.first)
                           .amid(around.count)
                           .at(edges, edges + 1));
  }
  if (opposed.count > 0) fail(name_, Fault::InconsistentOrientation, opposed);
}

/// Walks round each opening, from edge to edge across the fan of faces between them, which need not
/// be oriented alike. No edge has more than two faces.
Openings Inspection::openings() const {
  Openings found;
  std::vector<char> seen(twin_.size(), 0);
  for (size_t start = 0; start < twin_.size(); ++start) {
    if (twin_[start] >= 0 || seen[start] != 0) continue;
    long edges = 0;
    int h = static_cast<int>(start), v = target(h);
    while (seen[static_cast<size_t>(h)] == 0) {
      seen[static_cast<size_t>(h)] = 1;
      ++edges;
      // The other edge of the same face at v, and across it to the next, until there is none.
      const auto otherAt = [this](int edge, int vertex) {
        return target(edge) == vertex ? Connectivity::next(edge) : previous(edge);
      };
      h = otherAt(h, v);
      while (twin_[static_cast<size_t>(h)] >= 0) h = otherAt(twin_[static_cast<size_t>(h)], v);
      v = origin(h) == v ? target(h) : origin(h);
    }
    ++found.count;
    found.edgesOfLargest = std::max(found.edgesOfLargest, edges);
  }
  return found;
}

void Inspection::connectVertices() {
  const int n = vertexCount(), halfEdges = 3 * faceCount();
  offset_.assign(static_cast<size_t>(n) + 1, 0);
  std::vector<int> some(static_cast<size_t>(n), -1);  // one half-edge from each vertex
  for (int h = halfEdges - 1; h >= 0; --h) {
    some[origin(h)] = h;
    ++offset_[static_cast<size_t>(origin(h)) + 1];
  }
  Tally lonely, pinched;
  for (int v = 0; v < n; ++v)
    if (some[v] < 0) lonely.add(v);
  if (lonely.count > 0) fail(name_, Fault::UnreferencedVertex, lonely);
  std::partial_sum(offset_.begin(), offset_.end(), offset_.begin());
  outgoing_.resize(static_cast<size_t>(halfEdges));
  ring_.resize(static_cast<size_t>(halfEdges));
  for (int v = 0; v < n; ++v) {
    int i = offset_[v], h = some[v];
    do {
      outgoing_[i] = h;
      ring_[i++] = target(h);
      h = twin_[previous(h)];
    } while (h != some[v] && i < offset_[v + 1]);
    if (i < offset_[v + 1]) pinched.add(v);
  }
  if (pinched.count > 0) fail(name_, Fault::NonManifoldVertex, pinched);
}

void Inspection::checkTopology() const {
  const int n = vertexCount();
  std::vector<int> part(static_cast<size_t>(n), -1), stack;
  std::vector<int> first;  // a vertex of each part
  for (int seed = 0; seed < n; ++seed) {
    if (part[seed] >= 0) continue;
    const int label = static_cast<int>(first.size());
    first.push_back(seed);
    part[seed] = label;
    stack.push_back(seed);
    while (!stack.empty()) {
      const int v = stack.back();
      stack.pop_back();
      for (int w : ring(v))
        if (part[w] < 0) part[w] = label, stack.push_back(w);
    }
  }
  if (first.size() > 1)
    fail(name_, Fault::SeveralParts, {static_cast<long>(first.size()), first[1]});
  // Euler: V - E + F = 2 - 2 g, and E = 3 F / 2 on a closed surface.
  const long genus = (2 - (static_cast<long>(n) - faceCount() / 2)) / 2;
  if (genus != 0) fail(name_, Fault::Handles, {genus, -1});
}

void requireArea(const Points& vertices, const Triangles& faces, const std::string& name) {
  // Lengths are taken relative to the extent, so that neither tiny nor huge coordinates leave the
  // range of numbers.
  const Vector3 low = vertices.colwise().minCoeff(), high = vertices.colwise().maxCoeff();
  const Vector3 centre = 0.5 * low + 0.5 * high;
  const double extent = (0.5 * high - 0.5 * low).maxCoeff();
  const auto vertex = [&](Eigen::Index f, int k) -> Vector3 {
    return vertices.row(faces(f, k)).transpose();
  };
  double area = 0, volume = 0;
  if (extent > 0)
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
      const Vector3 a = (vertex(f, 0) - centre) / extent, b = (vertex(f, 1) - centre) / extent,
                    c = (vertex(f, 2) - centre) / extent;
      const Vector3 n = (b - a).cross(c - a);
      area += 0.5 * n.norm();
      volume += n.dot(a) / 6;
    }
  if (!(area > 0)) fail(name, Fault::ZeroArea, {faces.rows(), 0});
  constexpr double flat =
      1e-9;  // a flattened surface encloses nothing, up to rounding, and has no inside
  if (volume < -flat * std::pow(area, 1.5)) fail(name, Fault::InwardOrientation, {faces.rows(), 0});
}

}  // namespace

ClosedSurface::ClosedSurface(Points vertices, Triangles faces, std::string name)
    : name_(std::make_shared<const std::string>(std::move(name))) {
  auto connectivity = std::make_shared<Connectivity>();
  connectivity->faces = std::move(faces);
  Inspection(vertices, *connectivity, *name_).run();
  requireArea(vertices, connectivity->faces, *name_);
  connectivity_ = std::move(connectivity);
  vertices_ = std::make_shared<const Points>(std::move(vertices));
}

ClosedSurface::ClosedSurface(std::shared_ptr<const Connectivity> connectivity, Points vertices,
                             std::shared_ptr<const std::string> name)
    : connectivity_(std::move(connectivity)),
      vertices_(std::make_shared<const Points>(std::move(vertices))),
      name_(std::move(name)) {
  requireFinite(*vertices_, *name_);
  requireArea(*vertices_, faces(), *name_);
}

ClosedSurface ClosedSurface::withVertices(Points vertices) const {
  if (vertices.rows() != vertexCount())
    throw ArgumentError("Surface \"" + name() + "\" has " + std::to_string(vertexCount()) +
                        " vertices, and cannot get " + std::to_string(vertices.rows()) + ".");
  return {connectivity_, std::move(vertices), name_};
}

bool ClosedSurface::hasFacesOf(const ClosedSurface& other) const {
  return connectivity_ == other.connectivity_ ||
         (faceCount() == other.faceCount() && faces() == other.faces());
}

}  // namespace sphere_propagation
