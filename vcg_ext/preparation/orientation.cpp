// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/preparation/orientation.h"

#include <algorithm>
#include <utility>

namespace sphere_propagation {
namespace {

/// The faces of each part, parts in the order of their first face.
std::vector<std::vector<int>> partsOf(const Triangles& faces) {
  const EdgeTable edges(faces);
  DisjointSets sets(static_cast<int>(faces.rows()));
  for (int e = 0; e < edges.count(); ++e)
    for (int i = 1; i < edges.size(e); ++i)
      sets.unite(edges.halfEdge(e, 0) / 3, edges.halfEdge(e, i) / 3);
  std::vector<std::vector<int>> parts;
  std::vector<int> number(static_cast<size_t>(faces.rows()), -1);
  for (int f = 0; f < faces.rows(); ++f) {
    const int first = sets.find(f);
    if (number[first] < 0) {
      number[first] = static_cast<int>(parts.size());
      parts.emplace_back();
    }
    parts[number[first]].push_back(f);
  }
  return parts;
}

double areaOf(const BrokenMesh& mesh, const std::vector<int>& part) {
  double area = 0;
  for (const int f : part) area += areaVector(mesh.vertices, mesh.faces, f).norm() / 2;
  return area;
}

std::vector<double> areasOf(const BrokenMesh& mesh, const std::vector<std::vector<int>>& parts) {
  std::vector<double> areas;
  for (const std::vector<int>& part : parts) areas.push_back(areaOf(mesh, part));
  return areas;
}

size_t largestOf(const std::vector<double>& areas) {
  return static_cast<size_t>(std::max_element(areas.begin(), areas.end()) - areas.begin());
}

}  // namespace

void turnFace(BrokenMesh& mesh, int f) {
  std::swap(mesh.faces(f, 1), mesh.faces(f, 2));
  mesh.turned[f] = !mesh.turned[f];
}

DroppedSurfaces keepLargestSurface(BrokenMesh& mesh) {
  DroppedSurfaces dropped;
  const std::vector<std::vector<int>> parts = partsOf(mesh.faces);
  if (parts.size() < 2) return dropped;
  const std::vector<double> areas = areasOf(mesh, parts);
  const size_t largest = largestOf(areas);
  dropped.parts = static_cast<long>(parts.size()) - 1;
  for (size_t i = 0; i < parts.size(); ++i)
    if (i != largest && areas[largest] > 0)
      dropped.largestShare = std::max(dropped.largestShare, areas[i] / areas[largest]);
  std::vector<char> keep(mesh.faceLid.size(), 0);
  for (const int f : parts[largest]) keep[f] = 1;
  mesh.keepFaces(keep);
  return dropped;
}

void orientAlike(BrokenMesh& mesh) {
  const EdgeTable edges(mesh.faces);
  const auto origin = [&](int h) { return mesh.faces(h / 3, h % 3); };
  std::vector<int> against(mesh.faceLid.size(), -1);  // whether a face is against the first one
  for (int seed = 0; seed < mesh.faceCount(); ++seed) {
    if (against[seed] >= 0) continue;
    against[seed] = 0;
    std::vector<int> members{seed};
    for (size_t i = 0; i < members.size(); ++i)
      for (int h = 3 * members[i]; h < 3 * members[i] + 3; ++h) {
        const int g = edges.twin(h);
        if (g < 0 || against[g / 3] >= 0) continue;
        against[g / 3] = (origin(h) == origin(g)) != (against[members[i]] != 0) ? 1 : 0;
        members.push_back(g / 3);
      }
    double balance = 0;
    for (const int f : members)
      balance += (against[f] ? -1 : 1) * areaVector(mesh.vertices, mesh.faces, f).norm();
    if (balance < 0)
      for (const int f : members) against[f] = !against[f];
  }
  for (int f = 0; f < mesh.faceCount(); ++f)
    if (against[f]) turnFace(mesh, f);
}

bool isOneSided(const BrokenMesh& mesh) {
  const EdgeTable edges(mesh.faces);
  std::vector<char> opposed(mesh.faceLid.size(), 0);
  const auto origin = [&](int h) { return mesh.faces(h / 3, h % 3); };
  for (int e = 0; e < edges.count(); ++e) {
    if (edges.size(e) > 2) return false;
    if (edges.size(e) == 2 && origin(edges.halfEdge(e, 0)) == origin(edges.halfEdge(e, 1)))
      opposed[edges.halfEdge(e, 0) / 3] = 1;
  }
  const std::vector<std::vector<int>> parts = partsOf(mesh.faces);
  if (parts.empty()) return false;
  const std::vector<int>& part = parts[largestOf(areasOf(mesh, parts))];
  return std::any_of(part.begin(), part.end(), [&](int f) { return opposed[f] != 0; });
}

void orientOutwards(BrokenMesh& mesh) {
  for (const std::vector<int>& part : partsOf(mesh.faces)) {
    // From the middle of its corners, whose open edges then cost little.
    Vector3 centre = Vector3::Zero();
    for (const int f : part)
      for (int k = 0; k < 3; ++k) centre += mesh.vertex(mesh.faces(f, k));
    centre /= 3.0 * static_cast<double>(part.size());
    double volume = 0;
    for (const int f : part)
      volume +=
          areaVector(mesh.vertices, mesh.faces, f).dot(mesh.vertex(mesh.faces(f, 0)) - centre);
    if (volume < 0)
      for (const int f : part) turnFace(mesh, f);
  }
}

}  // namespace sphere_propagation
