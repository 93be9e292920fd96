// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/repair/relocation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <random>
#include <vector>

#include "vcg_ext/base/random.h"

namespace sphere_propagation {
namespace {

constexpr int passes = 60, growEvery = 12;
constexpr int towards = 4, roundMiddle = 12, roundHere = 12;  // places that are tried
constexpr double wide = 0.35, narrow = 0.1;                   // of the neighbours' distance
constexpr double least = 2e-14;                               // determinant of a face

double orientation(const Vector3& a, const Vector3& b, const Vector3& c) {
  return a.dot((b - a).cross(c - a));
}

class Relocation {
 public:
  Relocation(const Triangles& faces, Points& positions)
      : faces_(faces), positions_(positions), around_(static_cast<size_t>(positions.rows())) {
    for (int f = 0; f < faces.rows(); ++f)
      for (int k = 0; k < 3; ++k) around_[static_cast<size_t>(faces(f, k))].push_back(f);
  }

  std::vector<int> flipped() const {
    std::vector<int> found;
    for (int f = 0; f < faces_.rows(); ++f)
      if (!(orientation(at(faces_(f, 0)), at(faces_(f, 1)), at(faces_(f, 2))) > least))
        found.push_back(f);
    return found;
  }

  /// The vertices of these faces and so many rings around them, in order.
  std::vector<int> verticesOf(std::vector<int> faces, int rings) const {
    std::vector<int> vertices;
    for (int ring = 0;; ++ring) {
      vertices.clear();
      for (const int f : faces)
        for (int k = 0; k < 3; ++k) vertices.push_back(faces_(f, k));
      std::sort(vertices.begin(), vertices.end());
      vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
      if (ring == rings) return vertices;
      faces.clear();
      for (const int v : vertices)
        faces.insert(faces.end(), around_[static_cast<size_t>(v)].begin(),
                     around_[static_cast<size_t>(v)].end());
    }
  }

  void relocate(int v) {
    const std::vector<int>& its = around_[static_cast<size_t>(v)];
    Vector3 sum = Vector3::Zero();
    for (const int f : its)
      for (int k = 0; k < 3; ++k)
        if (faces_(f, k) != v) sum += at(faces_(f, k));
    const Vector3 here = at(v), middle = sum.stableNormalized();
    if (!(middle.squaredNorm() > 0.5)) return;
    double size = 0;
    for (const int f : its)
      for (int k = 0; k < 3; ++k)
        if (faces_(f, k) != v) size = std::max(size, (at(faces_(f, k)) - middle).norm());
    Vector3 best = here;
    double most = worstAt(v, here);
    const auto attempt = [&](const Vector3& place) {
      const Vector3 unit = place.stableNormalized();
      if (!(unit.squaredNorm() > 0.5)) return;
      if (const double worst = worstAt(v, unit); worst > most) {
        most = worst;
        best = unit;
      }
    };
    for (int i = 1; i <= towards; ++i)
      attempt(here + static_cast<double>(i) / towards * (middle - here));
    for (int i = 0; i < roundMiddle; ++i) attempt(middle + wide * size * someway());
    for (int i = 0; i < roundHere; ++i)
      attempt(here + narrow * size * uniformNumber(random_) * someway());
    positions_.row(v) = best.transpose();
  }

 private:
  Vector3 at(int v) const { return positions_.row(v).transpose(); }

  Vector3 someway() {
    Vector3 way;
    for (double& x : way) x = 2 * uniformNumber(random_) - 1;
    return way;
  }

  double worstAt(int v, const Vector3& place) const {
    double worst = 1;
    for (const int f : around_[static_cast<size_t>(v)]) {
      Vector3 corners[3];
      for (int k = 0; k < 3; ++k) corners[k] = faces_(f, k) == v ? place : at(faces_(f, k));
      worst = std::min(worst, orientation(corners[0], corners[1], corners[2]));
    }
    return worst;
  }

  const Triangles& faces_;
  Points& positions_;
  std::vector<std::vector<int>> around_;  // faces by vertex
  std::mt19937 random_{0};
};

}  // namespace

int relocateFlipped(const Triangles& faces, Points& positions) {
  Relocation relocation(faces, positions);
  std::vector<int> flipped = relocation.flipped();
  const auto count = static_cast<int>(flipped.size());
  for (int pass = 0; pass < passes && !flipped.empty(); ++pass) {
    for (const int v : relocation.verticesOf(flipped, pass / growEvery)) relocation.relocate(v);
    flipped = relocation.flipped();
  }
  return flipped.empty() ? count : -1;
}

}  // namespace sphere_propagation
