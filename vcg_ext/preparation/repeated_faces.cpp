// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/preparation/repeated_faces.h"

#include <algorithm>
#include <array>
#include <tuple>

namespace sphere_propagation {
namespace {

/// One round over a mesh whose faces without area are to be mended: what is changed once is left
/// alone until the next one.
class FlatFaceRound {
 public:
  explicit FlatFaceRound(BrokenMesh& mesh)
      : mesh_(mesh),
        edges_(mesh.faces),
        facesOf_(mesh.source.size()),
        touched_(mesh.source.size(), 0),
        keep_(mesh.faceLid.size(), 1) {
    for (int f = 0; f < mesh.faceCount(); ++f)
      for (int k = 0; k < 3; ++k) facesOf_[mesh.faces(f, k)].push_back(f);
  }

  int run() {
    int mended = 0;
    std::vector<int> flat;
    for (int f = 0; f < mesh_.faceCount(); ++f)
      if (isFlat(mesh_.vertices, mesh_.faces, f)) flat.push_back(f);
    for (const int f : flat) mended += mend(f);
    mesh_.keepFaces(keep_);
    return mended;
  }

 private:
  int corner(int h) const { return mesh_.faces(h / 3, h % 3); }
  static int next(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
  double length(int h) const {
    return (mesh_.vertex(corner(h)) - mesh_.vertex(corner(next(h)))).norm();
  }

  std::vector<int> neighbours(int v) const {
    std::vector<int> found;
    for (const int f : facesOf_[v])
      for (int k = 0; k < 3; ++k)
        if (mesh_.faces(f, k) != v) found.push_back(mesh_.faces(f, k));
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  bool untouched(int v) const {
    const std::vector<int> around = neighbours(v);
    return !touched_[v] &&
           std::none_of(around.begin(), around.end(), [this](int w) { return touched_[w] != 0; });
  }

  bool mend(int f) {
    for (int k = 0; k < 3; ++k)
      if (!untouched(mesh_.faces(f, k))) return false;
    int longest = 3 * f, shortest = 3 * f;
    for (int h = 3 * f; h < 3 * f + 3; ++h) {
      if (length(h) > length(longest)) longest = h;
      if (length(h) < length(shortest)) shortest = h;
    }
    if (length(shortest) <= 1e-9 * length(longest) || length(longest) == 0)
      return collapse(shortest);
    const int twin = edges_.twin(longest);
    if (twin >= 0) return flip(longest, twin);
    if (edges_.size(edges_.edgeOf(longest)) != 1) return false;
    keep_[f] = 0;
    touch(f);
    return true;
  }

  void touch(int f) {
    for (int k = 0; k < 3; ++k) touched_[mesh_.faces(f, k)] = 1;
  }

  bool flip(int h, int g) {
    const int a = corner(h), b = corner(next(h)), c = corner(next(next(h))),
              d = corner(next(next(g)));
    if (corner(g) != b || c == d || !untouched(d)) return false;
    const std::vector<int> around = neighbours(c);
    if (std::binary_search(around.begin(), around.end(), d)) return false;
    Triangles after(2, 3);
    after << c, a, d, d, b, c;
    if (isFlat(mesh_.vertices, after, 0) + isFlat(mesh_.vertices, after, 1) >=
        1 + isFlat(mesh_.vertices, mesh_.faces, g / 3))
      return false;
    mesh_.faces.row(h / 3) = after.row(0);
    mesh_.faces.row(g / 3) = after.row(1);
    touch(h / 3);
    touch(g / 3);
    return true;
  }

  bool collapse(int h) {
    const int gone = std::max(corner(h), corner(next(h))),
              kept = std::min(corner(h), corner(next(h)));
    const int faces = edges_.size(edges_.edgeOf(h));
    const std::vector<int> a = neighbours(gone), b = neighbours(kept);
    std::vector<int> common;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
    if (faces > 2 || static_cast<int>(common.size()) != faces) return false;
    if (faces == 2 && isOpen(gone) && isOpen(kept)) return false;
    for (const int v : a) touched_[v] = 1;
    for (const int v : b) touched_[v] = 1;
    for (const int f : facesOf_[gone]) {
      for (int k = 0; k < 3; ++k)
        if (mesh_.faces(f, k) == kept) keep_[f] = 0;
      for (int k = 0; k < 3; ++k)
        if (mesh_.faces(f, k) == gone && keep_[f]) mesh_.faces(f, k) = kept;
    }
    return true;
  }

  bool isOpen(int v) const {
    for (const int f : facesOf_[v])
      for (int h = 3 * f; h < 3 * f + 3; ++h)
        if ((corner(h) == v || corner(next(h)) == v) && edges_.size(edges_.edgeOf(h)) == 1)
          return true;
    return false;
  }

  BrokenMesh& mesh_;
  EdgeTable edges_;
  std::vector<std::vector<int>> facesOf_;
  std::vector<char> touched_, keep_;
};

}  // namespace

int dropFoldedFaces(BrokenMesh& mesh) {
  std::vector<char> keep(mesh.faceLid.size());
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const auto face = mesh.faces.row(f);
    keep[f] = face[0] != face[1] && face[1] != face[2] && face[2] != face[0];
  }
  return mesh.keepFaces(keep);
}

int dropNonFiniteVertices(BrokenMesh& mesh) {
  std::vector<char> finite(mesh.source.size()), keep(mesh.faceLid.size());
  for (int v = 0; v < mesh.vertexCount(); ++v) finite[v] = mesh.vertices.row(v).allFinite();
  for (int f = 0; f < mesh.faceCount(); ++f)
    keep[f] = finite[mesh.faces(f, 0)] && finite[mesh.faces(f, 1)] && finite[mesh.faces(f, 2)];
  mesh.keepFaces(keep);
  return mesh.keepVertices(finite);
}

int dropRepeatedFaces(BrokenMesh& mesh) {
  struct Key {
    std::array<int, 3> corners;
    int face;
    bool operator<(const Key& o) const {
      return std::tie(corners, face) < std::tie(o.corners, o.face);
    }
  };
  std::vector<Key> keys;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    keys.push_back({{mesh.faces(f, 0), mesh.faces(f, 1), mesh.faces(f, 2)}, f});
    std::sort(keys.back().corners.begin(), keys.back().corners.end());
  }
  std::sort(keys.begin(), keys.end());
  std::vector<char> keep(mesh.faceLid.size(), 1);
  for (size_t i = 1; i < keys.size(); ++i)
    if (keys[i].corners == keys[i - 1].corners) keep[keys[i].face] = 0;
  return mesh.keepFaces(keep);
}

bool isFlat(const Points& vertices, const Triangles& faces, int f) {
  double longest = 0;
  for (int k = 0; k < 3; ++k)
    longest = std::max(
        longest, (vertices.row(faces(f, k)) - vertices.row(faces(f, (k + 1) % 3))).squaredNorm());
  constexpr double height = 1e-9;
  return !(areaVector(vertices, faces, f).norm() > height * longest);
}

int mendFlatFaces(BrokenMesh& mesh) {
  constexpr int rounds = 50;
  int mended = 0;
  for (int i = 0; i < rounds; ++i) {
    bool any = false;
    for (int f = 0; f < mesh.faceCount() && !any; ++f) any = isFlat(mesh.vertices, mesh.faces, f);
    if (!any) break;
    const int now = FlatFaceRound(mesh).run();
    if (now == 0) break;
    mended += now;
  }
  return mended;
}

}  // namespace sphere_propagation
