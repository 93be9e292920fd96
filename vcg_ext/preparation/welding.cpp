// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/preparation/welding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "vcg_ext/preparation/repeated_faces.h"

namespace sphere_propagation {
namespace {

/// The vertices of edges that have one face.
std::vector<int> openVertices(const BrokenMesh& mesh) {
  const EdgeTable edges(mesh.faces);
  std::vector<int> open;
  for (int e = 0; e < edges.count(); ++e) {
    if (edges.size(e) != 1) continue;
    const int h = edges.halfEdge(e, 0);
    open.push_back(mesh.faces(h / 3, h % 3));
    open.push_back(mesh.faces(h / 3, (h + 1) % 3));
  }
  std::sort(open.begin(), open.end());
  open.erase(std::unique(open.begin(), open.end()), open.end());
  return open;
}

/// Faces take the first vertex of each set; those that then use one twice are gone.
int mergeSets(BrokenMesh& mesh, DisjointSets& sets) {
  std::vector<char> keep(mesh.source.size());
  for (int v = 0; v < mesh.vertexCount(); ++v) keep[v] = sets.find(v) == v;
  for (int f = 0; f < mesh.faceCount(); ++f)
    for (int k = 0; k < 3; ++k) mesh.faces(f, k) = sets.find(mesh.faces(f, k));
  return mesh.keepVertices(keep);
}

int weldExactly(BrokenMesh& mesh) {
  std::vector<int> open = openVertices(mesh);
  const auto place = [&](int v) {  // 0 and -0 are one place
    return std::make_tuple(mesh.vertices(v, 0) + 0.0, mesh.vertices(v, 1) + 0.0,
                           mesh.vertices(v, 2) + 0.0);
  };
  std::stable_sort(open.begin(), open.end(), [&](int a, int b) { return place(a) < place(b); });
  DisjointSets sets(mesh.vertexCount());
  for (size_t i = 1; i < open.size(); ++i)
    if (place(open[i]) == place(open[i - 1])) sets.unite(open[i], open[i - 1]);
  return mergeSets(mesh, sets);
}

/// The sheets (faces connected through edges with two faces) round each vertex, ascending.
std::vector<std::vector<int>> sheetsRound(const BrokenMesh& mesh) {
  const EdgeTable edges(mesh.faces);
  DisjointSets sheets(mesh.faceCount());
  for (int e = 0; e < edges.count(); ++e)
    if (edges.size(e) == 2) sheets.unite(edges.halfEdge(e, 0) / 3, edges.halfEdge(e, 1) / 3);
  std::vector<std::vector<int>> around(mesh.source.size());
  for (int f = 0; f < mesh.faceCount(); ++f)
    for (int k = 0; k < 3; ++k) around[mesh.faces(f, k)].push_back(sheets.find(f));
  for (std::vector<int>& of : around) {
    std::sort(of.begin(), of.end());
    of.erase(std::unique(of.begin(), of.end()), of.end());
  }
  return around;
}

bool haveCommon(const std::vector<int>& a, const std::vector<int>& b) {
  return std::any_of(a.begin(), a.end(),
                     [&b](int i) { return std::binary_search(b.begin(), b.end(), i); });
}

/// wasOpen: by source, what lay on an open edge before anything was welded.
int weldNearly(BrokenMesh& mesh, double tolerance, const std::vector<char>& wasOpen) {
  std::vector<char> open(mesh.source.size(), 0);
  for (const int v : openVertices(mesh)) open[v] = 1;
  if (std::find(open.begin(), open.end(), 1) == open.end()) return 0;
  const std::vector<std::vector<int>> sheets = sheetsRound(mesh);
  const double diagonal =
      (mesh.vertices.colwise().maxCoeff() - mesh.vertices.colwise().minCoeff()).norm();
  constexpr double unitOfFloat = 1.2e-7;
  const double reach =
      std::max(tolerance * diagonal, 2 * unitOfFloat * mesh.vertices.cwiseAbs().maxCoeff());
  std::vector<double> shortest(mesh.source.size(), std::numeric_limits<double>::infinity());
  for (int f = 0; f < mesh.faceCount(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.faces(f, k), b = mesh.faces(f, (k + 1) % 3);
      const double length = (mesh.vertex(a) - mesh.vertex(b)).norm();
      shortest[a] = std::min(shortest[a], length);
      shortest[b] = std::min(shortest[b], length);
    }
  // Swept along a direction in which no plane of a scanner or a box lies.
  const Vector3 sweep = Vector3(0.5312, 0.6173, 0.5803).normalized();
  struct Stop {
    double along;
    int vertex;
  };
  std::vector<Stop> stops;
  for (int v = 0; v < mesh.vertexCount(); ++v)
    if (open[v] || wasOpen[mesh.source[v]]) stops.push_back({sweep.dot(mesh.vertex(v)), v});
  std::sort(stops.begin(), stops.end(), [](const Stop& a, const Stop& b) {
    return std::tie(a.along, a.vertex) < std::tie(b.along, b.vertex);
  });
  DisjointSets sets(mesh.vertexCount());
  for (size_t i = 0; i < stops.size(); ++i)
    for (size_t j = i + 1; j < stops.size() && stops[j].along - stops[i].along <= reach; ++j) {
      const int a = stops[i].vertex, b = stops[j].vertex;
      if (!open[a] && !open[b]) continue;
      // Two rims that met exactly leave the third one open; but a hole is not the other side's.
      if (open[a] != open[b] && haveCommon(sheets[a], sheets[b])) continue;
      const double distance = (mesh.vertex(a) - mesh.vertex(b)).norm();
      if (distance <= reach && distance <= 0.1 * std::min(shortest[a], shortest[b]))
        sets.unite(a, b);
    }
  return mergeSets(mesh, sets);
}

}  // namespace

int weldOpenEdges(BrokenMesh& mesh, double tolerance) {
  std::vector<char> wasOpen;
  for (const int v : openVertices(mesh)) {
    const auto source = static_cast<size_t>(mesh.source[v]);
    if (source >= wasOpen.size()) wasOpen.resize(source + 1, 0);
    wasOpen[source] = 1;
  }
  for (const int source : mesh.source)
    if (static_cast<size_t>(source) >= wasOpen.size())
      wasOpen.resize(static_cast<size_t>(source) + 1, 0);
  int merged = weldExactly(mesh);
  dropFoldedFaces(mesh);
  merged += weldNearly(mesh, tolerance, wasOpen);
  dropFoldedFaces(mesh);
  return merged;
}

}  // namespace sphere_propagation
