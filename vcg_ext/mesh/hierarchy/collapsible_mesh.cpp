// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/hierarchy/collapsible_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <utility>

#include "vcg_ext/mesh/usable_extent.h"

namespace sphere_propagation {

CollapsibleMesh::CollapsibleMesh(const ClosedSurface& surface, const std::vector<int>& order)
    : points_(surface.vertexCount(), 3), vertexCount_(surface.vertexCount()) {
  const int n = vertexCount_, m = surface.faceCount();
  const Vector3 low = surface.vertices().colwise().minCoeff(),
                high = surface.vertices().colwise().maxCoeff();
  const double extent = (high - low).maxCoeff();
  for (int i = 0; i < n; ++i)
    points_.row(i) = ((surface.vertex(order[i]) - low) / extent).transpose();
  std::vector<int> rank(order.size());
  for (int i = 0; i < n; ++i) rank[order[i]] = i;
  // Faces by their first vertex, each beginning with it.
  std::vector<int> place(static_cast<size_t>(m)), firstCorner(static_cast<size_t>(m)),
      start(order.size() + 1, 0);
  const auto rankOf = [&](int f, int k) { return rank[surface.faces()(f, k)]; };
  for (int f = 0; f < m; ++f) {
    int k = 0;
    for (int l = 1; l < 3; ++l)
      if (rankOf(f, l) < rankOf(f, k)) k = l;
    firstCorner[f] = k;
    ++start[static_cast<size_t>(rankOf(f, k)) + 1];
  }
  std::partial_sum(start.begin(), start.end(), start.begin());
  for (int i = 0; i < n;
       ++i)  // counter-clockwise from the least neighbour, so that no order but this one matters
  {
    const IndexRange outgoing = surface.outgoing(order[i]);
    int least = 0;
    for (int j = 1; j < outgoing.size(); ++j)
      if (rank[surface.target(outgoing[j])] < rank[surface.target(outgoing[least])]) least = j;
    for (int j = 0; j < outgoing.size(); ++j) {
      const int h = outgoing[(least + j) % outgoing.size()];
      if (firstCorner[h / 3] == h % 3) place[h / 3] = start[i]++;
    }
  }
  const auto halfEdge = [&](int h) { return 3 * place[h / 3] + (h + 3 - firstCorner[h / 3]) % 3; };
  origin_.resize(3 * static_cast<size_t>(m));
  twin_.resize(origin_.size());
  some_.assign(static_cast<size_t>(n), -1);
  degree_.assign(static_cast<size_t>(n), 0);
  for (int h = 0; h < 3 * m; ++h) {
    const int g = halfEdge(h);
    origin_[g] = rank[surface.origin(h)];
    twin_[g] = halfEdge(surface.twin(h));
  }
  for (int h = 3 * m - 1; h >= 0; --h) {
    some_[origin_[h]] = h;
    ++degree_[origin_[h]];
  }
  area_.resize(static_cast<size_t>(m));
  double sum = 0;
  for (int f = 0; f < m; ++f) sum += area_[f] = static_cast<float>(flatArea(f));
  const auto least = static_cast<float>(minFaceShare * sum / m);
  for (float& area : area_) area = std::max(area, least);
  collapses_.reserve(static_cast<size_t>(n));
  formerAreas_.reserve(6 * static_cast<size_t>(n));
}

double CollapsibleMesh::flatArea(int f) const {
  const Vector3 a = point(origin_[3 * f]);
  return 0.5 * (point(origin_[3 * f + 1]) - a).cross(point(origin_[3 * f + 2]) - a).norm();
}

bool CollapsibleMesh::areNeighbours(int a, int b) const {
  if (degree_[b] < degree_[a]) std::swap(a, b);
  const int first = some_[a];
  int h = first;
  do {
    if (target(h) == b) return true;
    h = turned(h);
  } while (h != first);
  return false;
}

bool CollapsibleMesh::canCollapse(int h) const {
  if (vertexCount_ <= 4) return false;
  // Round u, counter-clockwise: h, the left one that u and v share anyway, ..., the right one.
  const int v = target(h), left = turned(h), right = next(twin_[h]);
  for (int g = turned(left); g != right; g = turned(g))
    if (areNeighbours(v, target(g))) return false;
  return true;
}

void CollapsibleMesh::collapse(int h) {
  const int o = twin_[h], u = origin_[h], v = target(h), left = origin_[previous(h)],
            right = origin_[previous(o)];
  // The edges that the two faces leave behind: p runs from left to v, q from u to left, and so on
  // the other side.
  const int p = twin_[next(h)], q = twin_[previous(h)], p2 = twin_[next(o)],
            q2 = twin_[previous(o)];
  double sum = 0, flat = 0;
  int count = 0;
  for (int f : {h / 3, o / 3}) {
    formerAreas_.push_back(area_[f]);
    sum += area_[f];
  }
  for (int g = q;; g = turned(g)) {
    origin_[g] = v;
    formerAreas_.push_back(area_[g / 3]);
    sum += area_[g / 3];
    flat += flatArea(g / 3);
    ++count;
    if (previous(g) == p2) break;
  }
  const double even = 0.1 * flat / count + 1e-30;
  for (int g = q;; g = turned(g)) {
    area_[g / 3] = static_cast<float>(sum * (flatArea(g / 3) + even) / (flat + count * even));
    if (previous(g) == p2) break;
  }
  twin_[p] = q;
  twin_[q] = p;
  twin_[p2] = q2;
  twin_[q2] = p2;
  some_[v] = q;
  some_[left] = p;
  some_[right] = p2;
  degree_[v] += degree_[u] - 4;
  --degree_[left];
  --degree_[right];
  degree_[u] = 0;
  collapses_.push_back(h);
  --vertexCount_;
}

int CollapsibleMesh::undo() {
  const int h = collapses_.back(), o = twin_[h], u = origin_[h], v = target(h);
  const int left = origin_[previous(h)], right = origin_[previous(o)];
  collapses_.pop_back();
  // The two faces still know their neighbours.
  const int p = twin_[next(h)], q = twin_[previous(h)], p2 = twin_[next(o)],
            q2 = twin_[previous(o)];
  int degree = 2;
  for (int g = q;; g = turned(g)) {
    ++degree;
    if (previous(g) == p2) break;
  }
  const float* former = formerAreas_.data() + (formerAreas_.size() - static_cast<size_t>(degree));
  area_[h / 3] = former[0];
  area_[o / 3] = former[1];
  const float* area = former + 2;
  for (int g = q;; g = turned(g)) {
    origin_[g] = u;
    area_[g / 3] = *area++;
    if (previous(g) == p2) break;
  }
  formerAreas_.resize(formerAreas_.size() - static_cast<size_t>(degree));
  twin_[p] = next(h);
  twin_[q] = previous(h);
  twin_[p2] = next(o);
  twin_[q2] = previous(o);
  some_[u] = h;
  some_[v] = o;
  some_[left] = previous(h);
  some_[right] = previous(o);
  degree_[u] = degree;
  degree_[v] += 4 - degree;
  ++degree_[left];
  ++degree_[right];
  ++vertexCount_;
  return u;
}

std::array<int, 4> CollapsibleMesh::tetrahedron() const {
  int first = 0;
  while (!isThere(first)) ++first;
  const int h = someHalfEdge(first), g = turned(h);
  return {first, target(h), target(g), target(turned(g))};
}

FaceRings CollapsibleMesh::rings(std::vector<int>& vertices, std::vector<int>& faceOf) const {
  const auto all = static_cast<size_t>(allVertices());
  FaceRings rings;
  std::vector<int> number(all, -1), faceNumber(origin_.size() / 3, -1);
  vertices.clear();
  for (size_t v = 0; v < all; ++v)
    if (degree_[v] > 0) {
      number[v] = static_cast<int>(vertices.size());
      vertices.push_back(static_cast<int>(v));
    }
  const int count = 2 * vertexCount_ - 4;
  rings.faces.resize(count, 3);
  faceOf.clear();
  faceOf.reserve(static_cast<size_t>(count));
  rings.offset.reserve(vertices.size() + 1);
  rings.offset.push_back(0);
  rings.corner.reserve(3 * static_cast<size_t>(count));
  for (int v : vertices) {
    const int first = some_[v];
    int h = first;
    do {
      const int f = h / 3;
      if (faceNumber[f] < 0) {
        faceNumber[f] = static_cast<int>(faceOf.size());
        for (int k = 0; k < 3; ++k) rings.faces(faceNumber[f], k) = number[origin_[3 * f + k]];
        faceOf.push_back(f);
      }
      rings.corner.push_back(3 * faceNumber[f] + h % 3);
      h = turned(h);
    } while (h != first);
    rings.offset.push_back(static_cast<int>(rings.corner.size()));
  }
  return rings;
}

}  // namespace sphere_propagation
