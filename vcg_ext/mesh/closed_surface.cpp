// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/closed_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>
#include <tuple>
#include <utility>

#include "vcg_ext/base/text.h"

namespace sphere_propagation {
namespace {

using Defect = SurfaceError::Defect;

/// How many elements have a defect, and which is the first.
struct Tally {
  long count = 0;
  long first = -1;
  void add(long index) {
    if (count++ == 0 || index < first) first = index;
  }
};

[[noreturn]] void fail(const std::string& name, Defect defect, const Tally& tally,
                       const std::string& what, const std::string& remedy) {
  std::ostringstream text;
  text << "Layer \"" << name << "\": " << what << ". " << remedy;
  throw SurfaceError(defect, tally.count, tally.first, text.str());
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
  if (bad.count > 0)
    fail(name, Defect::NonFiniteCoordinate, bad,
         counted(bad.count, "vertex has", "vertices have") +
             " coordinates that are not finite numbers, the first is vertex " +
             std::to_string(bad.first),
         "Select them with \"Conditional Vertex Selection\", condition \"x-x+y-y+z-z != 0\", then "
         "\"Delete Selected Vertices\" and \"Close Holes\".");
}

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
  if (m == 0)
    fail(name_, Defect::Empty, {}, n == 0 ? "it is empty" : "it has vertices but no faces",
         "Load a closed triangle mesh into this layer, or hide or delete the layer.");
  if (n < 4)
    fail(name_, Defect::TooFewVertices, {n, 0}, "it has " + counted(n, "vertex", "vertices"),
         "A closed surface has at least four.");
  requireFinite(vertices_, name_);
  Tally bad;
  for (int f = 0; f < m; ++f)
    if (faces_.row(f).minCoeff() < 0 || faces_.row(f).maxCoeff() >= n) bad.add(f);
  if (bad.count > 0)
    fail(name_, Defect::IndexOutOfRange, bad,
         counted(bad.count, "face refers", "faces refer") +
             " to vertices that do not exist, the first is face " + std::to_string(bad.first),
         "The file is damaged: export it again.");
  for (int f = 0; f < m; ++f)
    if (faces_(f, 0) == faces_(f, 1) || faces_(f, 1) == faces_(f, 2) ||
        faces_(f, 2) == faces_(f, 0))
      bad.add(f);
  if (bad.count > 0)
    fail(name_, Defect::DegenerateFace, bad,
         counted(bad.count, "face uses", "faces use") + " one vertex twice, the first is face " +
             std::to_string(bad.first),
         "Remove them with \"Remove Zero Area Faces\", then \"Close Holes\" if there are any.");
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
  if (crowded.count > 0)
    fail(name_, Defect::NonManifoldEdge, crowded,
         counted(crowded.count, "edge has", "edges have") +
             " more than two faces, the first at face " + std::to_string(crowded.first),
         "Repair them with \"Repair non Manifold Edges\" (remove faces), then \"Close Holes\".");
  if (open.count > 0) {
    const long coincident = coincidentVertices(vertices_);
    fail(name_, Defect::NotClosed, open,
         "it is not closed: " + counted(open.count, "edge has", "edges have") +
             " a face on one side only, the first at face " + std::to_string(open.first),
         coincident > 0
             ? std::to_string(coincident) +
                   " vertices lie exactly where another one lies: unify them with \"Remove "
                   "Duplicate Vertices\"; close what is still open with \"Close Holes\"."
             : "Close it with \"Close Holes\".");
  }
  if (opposed.count > 0)
    fail(name_, Defect::InconsistentOrientation, opposed,
         "its faces are not oriented alike: " + counted(opposed.count, "edge lies", "edges lie") +
             " between faces of opposite orientation, the first at face " +
             std::to_string(opposed.first),
         "Orient them with \"Re-Orient all faces coherently\"; should they point inwards then, "
         "\"Invert Faces Orientation\".");
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
  if (lonely.count > 0)
    fail(name_, Defect::UnreferencedVertex, lonely,
         counted(lonely.count, "vertex belongs", "vertices belong") +
             " to no face, the first is vertex " + std::to_string(lonely.first),
         "Remove them with \"Remove Unreferenced Vertices\".");
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
  if (pinched.count > 0)
    fail(name_, Defect::NonManifoldVertex, pinched,
         "at " + counted(pinched.count, "vertex", "vertices") +
             " sheets touch that share no edge there, the first is vertex " +
             std::to_string(pinched.first),
         "Separate them with \"Repair non Manifold Vertices by splitting\", then keep the largest "
         "part with \"Remove Isolated pieces (wrt Face Num.)\".");
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
    fail(name_, Defect::SeveralParts, {static_cast<long>(first.size()), first[1]},
         "it has " + std::to_string(first.size()) + " separate parts, vertex " +
             std::to_string(first[1]) + " is the first outside the part of vertex 0",
         "Keep the one that is meant with \"Remove Isolated pieces (wrt Face Num.)\".");
  // Euler: V - E + F = 2 - 2 g, and E = 3 F / 2 on a closed surface.
  const long genus = (2 - (static_cast<long>(n) - faceCount() / 2)) / 2;
  if (genus != 0)
    fail(name_, Defect::Handles, {genus, -1},
         "it has " + counted(genus, "handle", "handles") + " (genus " + std::to_string(genus) +
             "), and a sphere has none",
         "Remove them before meshing (fill the tunnels in the label image), or rebuild the surface "
         "with \"Surface Reconstruction: Screened Poisson\" at a lower depth.");
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
  if (!(area > 0))
    fail(name, Defect::ZeroArea, {faces.rows(), 0}, "all its faces have zero area",
         "There is no surface to map: load the mesh again.");
  constexpr double flat =
      1e-9;  // a flattened surface encloses nothing, up to rounding, and has no inside
  if (volume < -flat * std::pow(area, 1.5))
    fail(name, Defect::InwardOrientation, {faces.rows(), 0}, "its faces are oriented inwards",
         "Turn them round with \"Invert Faces Orientation\".");
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
    throw ParameterError("Surface \"" + name() + "\" has " + std::to_string(vertexCount()) +
                         " vertices, and cannot get " + std::to_string(vertices.rows()) + ".");
  return {connectivity_, std::move(vertices), name_};
}

bool ClosedSurface::hasFacesOf(const ClosedSurface& other) const {
  return connectivity_ == other.connectivity_ || faces() == other.faces();
}

}  // namespace sphere_propagation
