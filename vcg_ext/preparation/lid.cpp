// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/preparation/lid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "vcg_ext/base/linear_solvers.h"

namespace sphere_propagation {
namespace {

using Corners = std::array<int, 3>;

/// What a triangulation of a polygon costs; the least is the best.
struct Cost {
  double angle = 0, area = 0;
  Cost with(const Cost& o) const { return {std::max(angle, o.angle), area + o.area}; }
  // Angles that differ by rounding are the same.
  bool operator<(const Cost& o) const {
    constexpr double same = 1e-9;
    if (angle < o.angle - same) return true;
    return angle <= o.angle + same && area < o.area;
  }
};
constexpr Cost impossible{std::numeric_limits<double>::infinity(),
                          std::numeric_limits<double>::infinity()};

/// Of the angle between faces with these normals: 0 where they go on flat, 2 where they fold.
double bend(const Vector3& a, const Vector3& b) {
  if (a.isZero() || b.isZero()) return 0;
  return 1 - a.dot(b);
}

/// Dynamic programming over the polygon's chords.
class PolygonTriangulation {
 public:
  /// polygon: indices of the rim's points; walls: of each edge of the polygon the unit normal of
  /// the face on its other side, or zero.
  PolygonTriangulation(const Rim& rim, std::vector<int> polygon, std::vector<Vector3> walls,
                       bool withAngles)
      : rim_(rim),
        polygon_(std::move(polygon)),
        walls_(std::move(walls)),
        withAngles_(withAngles),
        n_(static_cast<int>(polygon_.size())),
        best_(static_cast<size_t>(n_) * static_cast<size_t>(n_)),
        middle_(best_.size(), -1) {}

  /// Appends its faces; false where there is no triangulation.
  bool appendTo(std::vector<Corners>& faces) {
    for (int length = 2; length < n_; ++length)
      for (int i = 0; i + length < n_; ++i) solve(i, i + length);
    if (n_ < 3 || std::isinf(best_[at(0, n_ - 1)].area)) return false;
    std::vector<std::pair<int, int>> chords{{0, n_ - 1}};
    while (!chords.empty()) {
      const auto [i, k] = chords.back();
      chords.pop_back();
      if (k - i < 2) continue;
      const int m = middle_[at(i, k)];
      faces.push_back({polygon_[i], polygon_[m], polygon_[k]});
      chords.emplace_back(m, k);
      chords.emplace_back(i, m);
    }
    return true;
  }

 private:
  size_t at(int i, int k) const { return static_cast<size_t>(i) * n_ + k; }
  Vector3 point(int i) const { return rim_.points.row(polygon_[i]).transpose(); }
  Vector3 cross(int i, int m, int k) const {
    return (point(m) - point(i)).cross(point(k) - point(i));
  }
  /// The normal on the other side of chord (i, k), seen from outside the polygon between them.
  Vector3 normalAt(int i, int k) const {
    if (k - i == 1) return walls_[i];
    return cross(i, middle_[at(i, k)], k).stableNormalized();
  }

  void solve(int i, int k) {
    Cost& best = best_[at(i, k)];
    best = impossible;
    const bool isSide = i == 0 && k == n_ - 1;
    if (!isSide && rim_.joined(polygon_[i], polygon_[k])) return;
    for (int m = i + 1; m < k; ++m) {
      if (std::isinf(best_[at(i, m)].area) || std::isinf(best_[at(m, k)].area)) continue;
      const Vector3 area = cross(i, m, k);
      Cost cost{0, area.norm()};
      if (withAngles_) {
        const Vector3 normal = area.stableNormalized();
        cost.angle = std::max(bend(normal, normalAt(i, m)), bend(normal, normalAt(m, k)));
        if (isSide) cost.angle = std::max(cost.angle, bend(normal, walls_[n_ - 1]));
      }
      cost = cost.with(best_[at(i, m)]).with(best_[at(m, k)]);
      if (cost < best || middle_[at(i, k)] < 0) {
        best = cost;
        middle_[at(i, k)] = m;
      }
    }
  }

  const Rim& rim_;
  std::vector<int> polygon_;
  std::vector<Vector3> walls_;
  bool withAngles_;
  int n_;
  std::vector<Cost> best_;  // of the polygon's part between two of its points
  std::vector<int> middle_;
};

/// The rim alone; empty where there is no triangulation.
std::vector<Corners> triangulated(const Rim& rim, bool withAngles) {
  constexpr int most = 200, coarse = 100;
  const int n = static_cast<int>(rim.points.rows());
  const int step = n <= most ? 1 : (n + coarse - 1) / coarse;
  std::vector<Corners> faces;
  std::vector<int> polygon;
  std::vector<Vector3> walls;
  for (int i = 0; i < n; i += step) {
    // The rest joins the last piece where it would be an edge that is there.
    const int end = std::min(i + step, n);
    polygon.push_back(i);
    walls.emplace_back(end - i == 1 ? Vector3(rim.wall.row(i).transpose()) : Vector3::Zero());
    if (end - i == 1) continue;
    std::vector<int> piece;
    std::vector<Vector3> pieceWalls;
    for (int j = i; j <= end; ++j) {
      piece.push_back(j % n);
      pieceWalls.emplace_back(j < end ? Vector3(rim.wall.row(j).transpose()) : Vector3::Zero());
    }
    if (rim.joined(i, end % n)) return {};
    if (!PolygonTriangulation(rim, piece, pieceWalls, withAngles).appendTo(faces)) return {};
  }
  if (!PolygonTriangulation(rim, polygon, walls, withAngles).appendTo(faces)) return {};
  return faces;
}

/// A lid that is being made.
class LidMesh {
 public:
  LidMesh(const Rim& rim, LidShape shape)
      : rim_(rim), shape_(shape), rimSize_(static_cast<int>(rim.points.rows())) {
    takeRim();
    faces_ = triangulated(rim, shape == LidShape::Curved);
    if (faces_.empty()) fan();
    for (int f = 0; f < static_cast<int>(faces_.size()); ++f) link(f);
  }

  /// Faces between several rims.
  LidMesh(const Rim& rim, const Triangles& faces)
      : rim_(rim), shape_(LidShape::Flat), rimSize_(static_cast<int>(rim.points.rows())) {
    takeRim();
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
      faces_.push_back({faces(f, 0), faces(f, 1), faces(f, 2)});
    for (int f = 0; f < static_cast<int>(faces_.size()); ++f) link(f);
  }

  Lid make() {
    flipEdges();
    refine();
    constexpr int rounds = 3;
    for (int i = 0; i < rounds; ++i) {
      placeAsMembrane();
      flipEdges();
    }
    if (shape_ == LidShape::Curved)
      for (int i = 0; i < rounds; ++i) {
        placeAsPlate();
        limitRise();
        flipEdges();
        refine();
      }
    if (shape_ == LidShape::Curved) {
      placeAsPlate();
      limitRise();
    }
    Lid lid{Points(count() - rimSize_, 3), Triangles(static_cast<Eigen::Index>(faces_.size()), 3)};
    for (int v = rimSize_; v < count(); ++v)
      lid.vertices.row(v - rimSize_) = points_[v].transpose();
    for (size_t f = 0; f < faces_.size(); ++f)
      for (int k = 0; k < 3; ++k) lid.faces(static_cast<Eigen::Index>(f), k) = faces_[f][k];
    return lid;
  }

 private:
  int count() const { return static_cast<int>(points_.size()); }

  void takeRim() {
    for (int i = 0; i < rimSize_; ++i) {
      points_.emplace_back(rim_.points.row(i).transpose());
      size_.push_back(rim_.spacing[i]);
    }
  }

  void fan() {
    points_.emplace_back(rim_.points.colwise().mean().transpose());
    size_.push_back(rim_.spacing.mean());
    for (int i = 0; i < rimSize_; ++i) faces_.push_back({i, (i + 1) % rimSize_, rimSize_});
  }

  void link(int f) {
    for (int k = 0; k < 3; ++k) faceAt_[{faces_[f][k], faces_[f][(k + 1) % 3]}] = f;
  }
  void unlink(int f) {
    for (int k = 0; k < 3; ++k) faceAt_.erase({faces_[f][k], faces_[f][(k + 1) % 3]});
  }
  /// The face left of the way from a to b; -1: none.
  int faceAt(int a, int b) const {
    const auto found = faceAt_.find({a, b});
    return found == faceAt_.end() ? -1 : found->second;
  }
  int apexOf(int f, int a, int b) const {
    for (const int v : faces_[f])
      if (v != a && v != b) return v;
    return -1;
  }
  Vector3 areaOf(int a, int b, int c) const {
    return (points_[b] - points_[a]).cross(points_[c] - points_[a]);
  }
  double cotangent(int apex, int a, int b) const {
    const Vector3 u = points_[a] - points_[apex], v = points_[b] - points_[apex];
    const double sine = u.cross(v).norm();
    return sine > 0 ? u.dot(v) / sine : u.dot(v) < 0 ? -1e12 : 1e12;
  }

  /// Flips the edge between a and b where that makes it Delaunay.
  bool flip(int a, int b) {
    const int f = faceAt(a, b), g = faceAt(b, a);
    if (f < 0 || g < 0) return false;
    const int c = apexOf(f, a, b), d = apexOf(g, a, b);
    constexpr double clearly = 1e-6;
    if (cotangent(c, a, b) + cotangent(d, a, b) >= -clearly) return false;
    if (c == d || faceAt(c, d) >= 0 || faceAt(d, c) >= 0) return false;
    if (c < rimSize_ && d < rimSize_ && rim_.joined(c, d)) return false;
    const Vector3 before = areaOf(a, b, c) + areaOf(b, a, d);
    if (areaOf(c, a, d).dot(before) <= 0 || areaOf(d, b, c).dot(before) <= 0) return false;
    unlink(f);
    unlink(g);
    faces_[f] = {c, a, d};
    faces_[g] = {d, b, c};
    link(f);
    link(g);
    return true;
  }

  void flipEdges() {
    constexpr int sweeps = 30;
    bool flipped = true;
    for (int i = 0; i < sweeps && flipped; ++i) {
      flipped = false;
      std::vector<std::pair<int, int>> edges;
      for (const auto& entry : faceAt_)
        if (entry.first.first < entry.first.second) edges.push_back(entry.first);
      for (const auto& [a, b] : edges) flipped = flip(a, b) || flipped;
    }
  }

  void refine() {
    constexpr int passes = 30, most = 50000;
    for (int i = 0; i < passes; ++i) {
      bool split = false;
      const int before = static_cast<int>(faces_.size());
      for (int f = 0; f < before && count() < most; ++f) split = splitIfLarge(f) || split;
      if (!split) return;
      flipEdges();
    }
  }

  bool splitIfLarge(int f) {
    const Corners corners = faces_[f];
    const Vector3 centre = (points_[corners[0]] + points_[corners[1]] + points_[corners[2]]) / 3;
    const double size = (size_[corners[0]] + size_[corners[1]] + size_[corners[2]]) / 3;
    for (const int v : corners) {
      const double distance = std::sqrt(2.0) * (centre - points_[v]).norm();
      if (distance <= size || distance <= size_[v]) return false;
    }
    const int v = count();
    points_.push_back(centre);
    size_.push_back(size);
    unlink(f);
    faces_[f] = {corners[0], corners[1], v};
    faces_.push_back({corners[1], corners[2], v});
    faces_.push_back({corners[2], corners[0], v});
    link(f);
    link(static_cast<int>(faces_.size()) - 2);
    link(static_cast<int>(faces_.size()) - 1);
    return true;
  }

  /// Cotangents, kept in bounds: needles at the rim would outweigh all else.
  static double bounded(double weight) { return std::clamp(weight, 0.05, 5.0); }

  /// The Laplacian of all points, and a third of the area round each.
  void laplacian(const std::vector<Corners>& faces, int size, SparseCholesky::Matrix& matrix,
                 Eigen::VectorXd& mass) const {
    std::vector<Eigen::Triplet<double>> entries;
    mass = Eigen::VectorXd::Zero(size);
    for (const Corners& face : faces)
      for (int k = 0; k < 3; ++k) {
        const int a = face[k], b = face[(k + 1) % 3], c = face[(k + 2) % 3];
        const double weight = 0.5 * bounded(cotangent(c, a, b));
        entries.emplace_back(a, b, weight);
        entries.emplace_back(b, a, weight);
        entries.emplace_back(a, a, -weight);
        entries.emplace_back(b, b, -weight);
        mass[c] += areaOf(a, b, c).norm() / 6;
      }
    matrix.resize(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
  }

  /// Moves the lid's new vertices, of which there are `size` with the rim, to where x^T energy x is
  /// least, all other points staying.
  void place(const SparseCholesky::Matrix& energy, int size) {
    const int unknown = size - rimSize_;
    const auto isNew = [&](Eigen::Index v) { return v >= rimSize_ && v < size; };
    std::vector<Eigen::Triplet<double>> inside;
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(unknown, 3);
    for (int column = 0; column < energy.outerSize(); ++column)
      for (SparseCholesky::Matrix::InnerIterator it(energy, column); it; ++it) {
        if (!isNew(it.row())) continue;
        const Eigen::Index i = it.row() - rimSize_;
        if (isNew(it.col()))
          inside.emplace_back(i, it.col() - rimSize_, it.value());
        else
          right.row(i) -= it.value() * points_[it.col()].transpose();
      }
    SparseCholesky::Matrix matrix(unknown, unknown);
    matrix.setFromTriplets(inside.begin(), inside.end());
    SparseCholesky solver;
    solver.compute(matrix);
    if (!solver.succeeded()) return;
    const Eigen::MatrixXd solution = solver.solve(right);
    if (!solution.allFinite()) return;
    for (int i = 0; i < unknown; ++i) points_[rimSize_ + i] = solution.row(i).transpose();
  }

  void placeAsMembrane() {
    if (count() == rimSize_) return;
    SparseCholesky::Matrix matrix;
    Eigen::VectorXd mass;
    laplacian(faces_, count(), matrix, mass);
    place(-matrix, count());
  }

  void placeAsPlate() {
    if (count() == rimSize_) return;
    // The wall goes down from the rim as a strip one edge wide.
    std::vector<Corners> faces = faces_;
    const int plain = count();
    for (int i = 0; i < rimSize_; ++i) {
      points_.push_back(points_[i] - rim_.spacing[i] * rim_.onward.row(i).transpose());
      const int j = (i + 1) % rimSize_;
      faces.push_back({j, i, plain + i});
      faces.push_back({j, plain + i, plain + j});
    }
    const int size = plain + rimSize_;
    SparseCholesky::Matrix matrix;
    Eigen::VectorXd mass;
    laplacian(faces, size, matrix, mass);
    Eigen::VectorXd inverse = Eigen::VectorXd::Zero(size);  // the strip's outer side is free
    const double floor = 1e-3 * mass.head(plain).mean();
    for (int v = 0; v < plain; ++v) inverse[v] = 1 / std::max(mass[v], floor);
    const SparseCholesky::Matrix energy = matrix.transpose() * inverse.asDiagonal() * matrix;
    place(energy, plain);
    points_.resize(static_cast<size_t>(plain));
  }

  /// A plate that rises over the membrane by more than a cap would, as where the rim is ragged, is
  /// brought nearer to it as a whole.
  void limitRise() {
    constexpr double most = 0.6;  // of the greatest distance from the rim; half is a hemisphere's
    if (count() == rimSize_) return;
    const std::vector<Vector3> plate = points_;
    placeAsMembrane();
    double rise = 0, reach = 0;
    for (int v = rimSize_; v < count(); ++v) {
      double nearest = std::numeric_limits<double>::infinity();
      for (int i = 0; i < rimSize_; ++i)
        nearest = std::min(nearest, (points_[v] - points_[i]).squaredNorm());
      reach = std::max(reach, nearest);
      rise = std::max(rise, (plate[v] - points_[v]).norm());
    }
    const double share = std::min(1.0, most * std::sqrt(reach) / std::max(rise, 1e-300));
    for (int v = rimSize_; v < count(); ++v) points_[v] += share * (plate[v] - points_[v]);
  }

  const Rim& rim_;
  LidShape shape_;
  int rimSize_;
  std::vector<Vector3> points_;
  std::vector<double> size_;  // of the edges that each point wants
  std::vector<Corners> faces_;
  std::map<std::pair<int, int>, int> faceAt_;
};

}  // namespace

namespace {

/// Whether a rim leaves the line from its point a to its point b (b up to n, which is point 0), or
/// turns back on it.
bool leavesLine(const Rim& rim, int a, int b) {
  constexpr double aside = 0.05;  // of the spacing
  const auto n = static_cast<int>(rim.points.rows());
  const Vector3 from = rim.points.row(a).transpose(), to = rim.points.row(b % n).transpose();
  const Vector3 along = (to - from).stableNormalized();
  double before = 0;
  for (int i = a + 1; i < b; ++i) {
    const Vector3 way = rim.points.row(i).transpose() - from;
    const double t = way.dot(along);
    if (t < before || (way - t * along).norm() > aside * rim.spacing[i]) return true;
    before = t;
  }
  return before > (to - from).norm();
}

/// Of a rim the points that are as far apart as its edges are to be, or where it turns, in order;
/// all where few would be left.
std::vector<int> sparse(const Rim& rim) {
  constexpr double near = 0.35;  // of the spacing
  constexpr size_t fewest = 8;
  const auto n = static_cast<int>(rim.points.rows());
  std::vector<int> kept{0};
  double since = 0;  // on the way from the last one
  const auto step = [&](int i) { return (rim.points.row(i % n) - rim.points.row(i - 1)).norm(); };
  for (int i = 1; i <= n; ++i) {
    since += step(i);
    if (leavesLine(rim, kept.back(), i)) {
      kept.push_back(i - 1);
      since = step(i);
    }
    if (i == n || since < near * rim.spacing[i]) continue;
    kept.push_back(i);
    since = 0;
  }
  // The last one beside the first.
  if (kept.size() > fewest && since < near * rim.spacing[0] &&
      !leavesLine(rim, kept[kept.size() - 2], n))
    kept.pop_back();
  if (kept.size() < fewest) {
    kept.resize(static_cast<size_t>(n));
    std::iota(kept.begin(), kept.end(), 0);
  }
  return kept;
}

/// The rim at some of its points.
Rim rimAt(const Rim& rim, const std::vector<int>& kept) {
  const auto n = static_cast<Eigen::Index>(kept.size());
  Rim part{Points(n, 3), Points::Zero(n, 3), Eigen::VectorXd(n), Points(n, 3), {}};
  for (size_t k = 0; k < kept.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    part.points.row(row) = rim.points.row(kept[k]);
    part.spacing[row] = rim.spacing[kept[k]];
    part.onward.row(row) = rim.onward.row(kept[k]);
    // Of the faces beside a longer edge those that lie along most of it count.
    const int end = k + 1 < kept.size() ? kept[k + 1] : static_cast<int>(rim.points.rows());
    Vector3 wall = Vector3::Zero();
    for (int i = kept[k]; i < end; ++i) {
      const Eigen::Index next = (i + 1) % rim.points.rows();
      wall += (rim.points.row(next) - rim.points.row(i)).norm() * rim.wall.row(i).transpose();
    }
    part.wall.row(row) = wall.stableNormalized().transpose();
  }
  part.joined = [&rim, kept](int i, int j) { return rim.joined(kept[i], kept[j]); };
  return part;
}

/// The lid of a rim at `kept`, as one of the whole rim: its faces at the rim are split at the
/// points between. Nothing where that would join points that are joined. folded: gets the points
/// where a face folds back on what it was a part of.
std::optional<Lid> withAllPoints(const Lid& lid, const Rim& rim, const std::vector<int>& kept,
                                 std::vector<int>& folded) {
  const auto n = static_cast<int>(rim.points.rows()), few = static_cast<int>(kept.size());
  std::map<std::pair<int, int>, int> edges;  // of the rim at `kept`: where its points end
  for (size_t k = 0; k < kept.size(); ++k) {
    const int end = k + 1 < kept.size() ? kept[k + 1] : n;
    if (end - kept[k] > 1) edges[{kept[k], end % n}] = end;
  }
  const auto point = [&](int v) -> Vector3 {
    return (v < n ? rim.points.row(v) : lid.vertices.row(v - n)).transpose();
  };
  const auto normal = [&](int a, int b, int c) -> Vector3 {
    return (point(b) - point(a)).cross(point(c) - point(a)).stableNormalized();
  };
  std::vector<Corners> faces, split;
  for (Eigen::Index f = 0; f < lid.faces.rows(); ++f) {
    Corners face{};
    for (int k = 0; k < 3; ++k) {
      const int v = lid.faces(f, k);
      face[k] = v < few ? kept[static_cast<size_t>(v)] : v - few + n;
    }
    faces.push_back(face);
  }
  while (!faces.empty()) {
    const Corners face = faces.back();
    faces.pop_back();
    int k = 0;
    while (k < 3 && edges.count({face[k], face[(k + 1) % 3]}) == 0) ++k;
    if (k == 3) {
      split.push_back(face);
      continue;
    }
    const int apex = face[(k + 2) % 3], end = edges.at({face[k], face[(k + 1) % 3]});
    const Vector3 whole = normal(face[k], face[(k + 1) % 3], apex);
    for (int i = face[k]; i < end; ++i) {
      constexpr double turned = 0.5;  // cosine
      if (normal(i, (i + 1) % n, apex).dot(whole) < turned)
        for (const int v : {i, i + 1})
          if (v > face[k] && v < end) folded.push_back(v);
      if (i > face[k] && apex < n && rim.joined(apex, i)) return std::nullopt;
      faces.push_back({i, (i + 1) % n, apex});
    }
  }
  Lid whole{lid.vertices, Triangles(static_cast<Eigen::Index>(split.size()), 3)};
  for (size_t f = 0; f < split.size(); ++f)
    for (int k = 0; k < 3; ++k) whole.faces(static_cast<Eigen::Index>(f), k) = split[f][k];
  return whole;
}

/// A rim in units of its own, round its own middle: numbers are the same in mm and in m.
class OwnUnits {
 public:
  explicit OwnUnits(const Rim& rim)
      : centre_(rim.points.colwise().mean()),
        unit_(rim.spacing.mean() > 0 ? rim.spacing.mean() : 1) {}
  Rim of(Rim rim) const {
    rim.points = (rim.points.rowwise() - centre_) / unit_;
    rim.spacing /= unit_;
    return rim;
  }
  Lid back(Lid lid) const {
    lid.vertices = (unit_ * lid.vertices).rowwise() + centre_;
    return lid;
  }

 private:
  Eigen::RowVector3d centre_;
  double unit_;
};

}  // namespace

Triangles polygonFaces(const Rim& rim, const std::vector<int>& polygon) {
  constexpr int most = 400, coarse = 200;
  const auto n = static_cast<int>(polygon.size());
  const int step = n <= most ? 1 : (n + coarse - 1) / coarse;
  std::vector<int> times(static_cast<size_t>(rim.points.rows()), 0);
  for (const int v : polygon) ++times[v];
  std::vector<Corners> faces;
  std::vector<int> nodes;
  const auto solve = [&](const std::vector<int>& part) {
    const std::vector<Vector3> walls(part.size(), Vector3::Zero());
    return PolygonTriangulation(rim, part, walls, false).appendTo(faces);
  };
  for (int i = 0; i < n;) {
    nodes.push_back(polygon[i]);
    std::vector<int> piece{polygon[i]};
    do piece.push_back(polygon[++i % n]);
    while (i < n && static_cast<int>(piece.size()) <= step && times[polygon[i % n]] == 1);
    if (piece.size() == 2) continue;
    if (rim.joined(piece.front(), piece.back()) || !solve(piece)) return Triangles(0, 3);
  }
  if (!solve(nodes)) return Triangles(0, 3);
  std::map<std::pair<int, int>, int> uses;
  Triangles result(static_cast<Eigen::Index>(faces.size()), 3);
  for (size_t f = 0; f < faces.size(); ++f)
    for (int k = 0; k < 3; ++k) {
      result(static_cast<Eigen::Index>(f), k) = faces[f][k];
      if (++uses[{faces[f][k], faces[f][(k + 1) % 3]}] > 1) return Triangles(0, 3);
    }
  return result;
}

Lid makeBand(const Rim& rim, const Triangles& faces) {
  const OwnUnits units(rim);
  const Rim scaled = units.of(rim);
  return units.back(LidMesh(scaled, faces).make());
}

Lid makeLid(const Rim& rim, LidShape shape) {
  const OwnUnits units(rim);
  const Rim scaled = units.of(rim);
  std::vector<int> kept = sparse(scaled);
  std::optional<Lid> made;
  constexpr int rounds = 4;
  for (int i = 0; i < rounds && static_cast<Eigen::Index>(kept.size()) < rim.points.rows(); ++i) {
    const Rim some = rimAt(scaled, kept);
    std::vector<int> folded;
    made = withAllPoints(LidMesh(some, shape).make(), scaled, kept, folded);
    if (!made || folded.empty()) break;
    kept.insert(kept.end(), folded.begin(), folded.end());
    std::sort(kept.begin(), kept.end());
    kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  }
  return units.back(made ? std::move(*made) : LidMesh(scaled, shape).make());
}

}  // namespace sphere_propagation
