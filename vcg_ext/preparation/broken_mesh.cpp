// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/preparation/broken_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

namespace sphere_propagation {

BrokenMesh::BrokenMesh(Points points, Triangles triangles)
    : vertices(std::move(points)),
      faces(std::move(triangles)),
      source(static_cast<size_t>(vertices.rows())),
      lid(static_cast<size_t>(vertices.rows()), 0),
      faceLid(static_cast<size_t>(faces.rows()), 0),
      turned(static_cast<size_t>(faces.rows()), 0),
      separated(static_cast<size_t>(vertices.rows())) {
  std::iota(source.begin(), source.end(), 0);
  std::iota(separated.begin(), separated.end(), 0);
}

int BrokenMesh::addCopiesOf(const std::vector<int>& originals) {
  Points points(static_cast<Eigen::Index>(originals.size()), 3);
  for (size_t i = 0; i < originals.size(); ++i)
    points.row(static_cast<Eigen::Index>(i)) = vertices.row(originals[i]);
  const int first = addVertices(points, 0);
  for (size_t i = 0; i < originals.size(); ++i) {
    const size_t w = static_cast<size_t>(first) + i;
    source[w] = source[originals[i]];
    lid[w] = lid[originals[i]];
    separated[w] = separated[originals[i]];
  }
  return first;
}

int BrokenMesh::addVertices(const Points& points, int lidNumber) {
  const int first = vertexCount();
  vertices.conservativeResize(first + points.rows(), 3);
  vertices.bottomRows(points.rows()) = points;
  source.resize(source.size() + static_cast<size_t>(points.rows()), -1);
  lid.resize(source.size(), lidNumber);
  for (int v = first; v < vertexCount(); ++v) separated.push_back(v);
  return first;
}

void BrokenMesh::addFaces(const Triangles& added, int lidNumber, char isTurned) {
  faces.conservativeResize(faces.rows() + added.rows(), 3);
  faces.bottomRows(added.rows()) = added;
  faceLid.resize(static_cast<size_t>(faces.rows()), lidNumber);
  turned.resize(static_cast<size_t>(faces.rows()), isTurned);
}

int BrokenMesh::keepFaces(const std::vector<char>& keep) {
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    if (!keep[static_cast<size_t>(f)]) continue;
    faces.row(kept) = faces.row(f).eval();
    faceLid[static_cast<size_t>(kept)] = faceLid[static_cast<size_t>(f)];
    turned[static_cast<size_t>(kept)] = turned[static_cast<size_t>(f)];
    ++kept;
  }
  const int dropped = static_cast<int>(faces.rows() - kept);
  faces.conservativeResize(kept, 3);
  faceLid.resize(static_cast<size_t>(kept));
  turned.resize(static_cast<size_t>(kept));
  return dropped;
}

int BrokenMesh::keepVertices(const std::vector<char>& keep) {
  std::vector<int> number(keep.size(), -1);
  int kept = 0;
  for (size_t v = 0; v < keep.size(); ++v) {
    if (!keep[v]) continue;
    const auto k = static_cast<size_t>(kept);
    vertices.row(kept) = vertices.row(static_cast<Eigen::Index>(v)).eval();
    source[k] = source[v];
    lid[k] = lid[v];
    number[v] = kept++;
    // The first of those that were one may be gone: the next takes its place.
    const int first = separated[v];
    separated[k] = number[static_cast<size_t>(first)];
    if (separated[k] < 0) {
      separated[k] = static_cast<int>(k);
      number[static_cast<size_t>(first)] = static_cast<int>(k);
    }
  }
  const int dropped = static_cast<int>(keep.size()) - kept;
  vertices.conservativeResize(kept, 3);
  source.resize(static_cast<size_t>(kept));
  lid.resize(static_cast<size_t>(kept));
  separated.resize(static_cast<size_t>(kept));
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) faces(f, k) = number[static_cast<size_t>(faces(f, k))];
  return dropped;
}

int BrokenMesh::dropUnusedVertices(const std::vector<char>& spared) {
  std::vector<char> keep(source.size(), 0);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) keep[static_cast<size_t>(faces(f, k))] = 1;
  if (!spared.empty())
    for (size_t v = 0; v < keep.size(); ++v)
      if (source[v] >= 0 && spared[static_cast<size_t>(source[v])]) keep[v] = 1;
  return keepVertices(keep);
}

Vector3 areaVector(const Points& vertices, const Triangles& faces, int f) {
  const Vector3 a = vertices.row(faces(f, 0)), b = vertices.row(faces(f, 1)),
                c = vertices.row(faces(f, 2));
  return (b - a).cross(c - a);
}

double areaOf(const BrokenMesh& mesh) {
  double area = 0;
  for (int f = 0; f < mesh.faceCount(); ++f)
    area += areaVector(mesh.vertices, mesh.faces, f).norm() / 2;
  return area;
}

EdgeTable::EdgeTable(const Triangles& faces) {
  const int count = 3 * static_cast<int>(faces.rows());
  const auto ends = [&](int h) {
    const int a = faces(h / 3, h % 3), b = faces(h / 3, (h + 1) % 3);
    return std::make_pair(std::min(a, b), std::max(a, b));
  };
  struct Entry {
    int smaller, larger, halfEdge;
    bool operator<(const Entry& o) const {
      return std::tie(smaller, larger, halfEdge) < std::tie(o.smaller, o.larger, o.halfEdge);
    }
  };
  std::vector<Entry> entries(static_cast<size_t>(count));
  for (int h = 0; h < count; ++h) {
    const auto [a, b] = ends(h);
    entries[static_cast<size_t>(h)] = {a, b, h};
  }
  std::sort(entries.begin(), entries.end());
  edgeOf_.resize(static_cast<size_t>(count));
  halfEdges_.resize(static_cast<size_t>(count));
  for (size_t i = 0; i < entries.size(); ++i) {
    if (i == 0 || entries[i].smaller != entries[i - 1].smaller ||
        entries[i].larger != entries[i - 1].larger)
      start_.push_back(static_cast<int>(i));
    halfEdges_[i] = entries[i].halfEdge;
    edgeOf_[static_cast<size_t>(entries[i].halfEdge)] = static_cast<int>(start_.size()) - 1;
  }
  start_.push_back(count);
}

DisjointSets::DisjointSets(int count) : parent_(static_cast<size_t>(count)) {
  std::iota(parent_.begin(), parent_.end(), 0);
}

int DisjointSets::find(int i) {
  while (parent_[i] != i) {
    parent_[i] = parent_[parent_[i]];
    i = parent_[i];
  }
  return i;
}

bool DisjointSets::unite(int i, int j) {
  i = find(i);
  j = find(j);
  if (i == j) return false;
  parent_[std::max(i, j)] = std::min(i, j);
  return true;
}

}  // namespace sphere_propagation
