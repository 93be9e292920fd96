// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/preparation/surface_preparation.h"

#include <algorithm>
#include <utility>

#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/mesh/usable_extent.h"
#include "vcg_ext/preparation/handle_removal.h"
#include "vcg_ext/preparation/repeated_faces.h"
#include "vcg_ext/preparation/welding.h"

namespace sphere_propagation {
namespace {

/// Why a mesh is not a closed surface that encloses something; nothing where it is one.
std::optional<Finding> findingOf(const Points& vertices, const Triangles& faces,
                                 const std::string& name) {
  try {
    requireUsableExtent(ClosedSurface(vertices, faces, name));
  } catch (const SurfaceError& error) {
    return error.finding();
  }
  return std::nullopt;
}

void requireIndices(const Points& vertices, const Triangles& faces, const std::string& name) {
  long count = 0, first = -1;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    if (faces.row(f).minCoeff() < 0 || faces.row(f).maxCoeff() >= vertices.rows())
      if (count++ == 0) first = f;
  if (count > 0) throw SurfaceError(Finding(Fault::IndexOutOfRange, name).of(count, first));
}

bool hasFlatFaces(const Points& vertices, const Triangles& faces) {
  for (int f = 0; f < faces.rows(); ++f)
    if (isFlat(vertices, faces, f)) return true;
  return false;
}

PreparedMesh resultOf(BrokenMesh mesh, PreparedMesh result) {
  result.vertices = std::move(mesh.vertices);
  result.faces = std::move(mesh.faces);
  result.source = std::move(mesh.source);
  result.lid = std::move(mesh.lid);
  result.faceLid = std::move(mesh.faceLid);
  return result;
}

}  // namespace

PreparedMesh preparedMesh(const Points& vertices, const Triangles& faces,
                          const PreparationParameters& parameters, const std::string& name,
                          const Progress& progress) {
  PreparedMesh result;
  BrokenMesh mesh(vertices, faces);
  result.left = findingOf(vertices, faces, name);
  if (result.left) switch (result.left->fault) {
      case Fault::Empty:
      case Fault::NoFaces:
        throw SurfaceError(*result.left);
      default:
        break;
    }
  requireIndices(vertices, faces, name);
  if (!result.left && !(parameters.removeDuplicateFaces && hasFlatFaces(vertices, faces)))
    return resultOf(std::move(mesh), std::move(result));

  std::vector<char> spared;  // vertices that no face used, where they are not to go
  if (!parameters.weld) {
    spared.assign(mesh.source.size(), 1);
    for (int f = 0; f < mesh.faceCount(); ++f)
      for (int k = 0; k < 3; ++k) spared[faces(f, k)] = 0;
  }
  result.nonFiniteVertices = dropNonFiniteVertices(mesh);
  result.duplicateFaces = dropFoldedFaces(mesh);
  result.unusedVertices = mesh.dropUnusedVertices(spared);
  if (parameters.weld) result.weldedVertices = weldOpenEdges(mesh);
  report(progress, 0.1);
  if (parameters.removeDuplicateFaces) result.duplicateFaces += dropRepeatedFaces(mesh);
  if (parameters.removeFins) result.sheets = separateSheets(mesh);
  report(progress, 0.3);
  JoinedShells joined;
  if (parameters.joinShells) {
    joined = joinShells(mesh);
    result.openings = joined.rings;
    result.rings = static_cast<int>(joined.rings.size());
    result.joinedShells = joined.shells;
  } else if (parameters.keepLargestComponent || parameters.closeOpenings) {
    result.shells = hasShells(mesh);
  }
  if (parameters.keepLargestComponent) result.dropped = keepLargestSurface(mesh);
  orientAlike(mesh);  // which openings need; turned back below where it is not asked for
  if (parameters.removeDuplicateFaces) result.flatFaces = mendFlatFaces(mesh);
  report(progress, 0.4);
  if (parameters.closeOpenings)
    result.openings = closeOpenings(mesh, parameters.lid, part(progress, 0.4, 0.9), joined);
  if (parameters.removeDuplicateFaces) result.flatFaces += mendFlatFaces(mesh);
  orientOutwards(mesh);
  result.oneSided = isOneSided(mesh);
  if (!parameters.orient)
    for (int f = 0; f < mesh.faceCount(); ++f)
      if (mesh.turned[f]) turnFace(mesh, f);
  for (int f = 0; f < mesh.faceCount(); ++f)
    result.turnedFaces += mesh.turned[f] && mesh.faceLid[f] == 0;
  mesh.dropUnusedVertices(spared);
  result.changed = mesh.vertices.rows() != vertices.rows() || mesh.faces.rows() != faces.rows() ||
                   mesh.faces != faces;
  result.left = findingOf(mesh.vertices, mesh.faces, name);
  if (parameters.removeHandles && result.left && result.left->fault == Fault::Handles) {
    report(progress, 0.9);
    RemadeSurface remade = withoutHandles(mesh.vertices, mesh.faces);
    const std::vector<int> faceLid = mesh.faceLid;
    mesh = BrokenMesh(std::move(remade.vertices), std::move(remade.faces));
    mesh.source.assign(mesh.source.size(), -1);
    for (int v = 0; v < mesh.vertexCount(); ++v) mesh.lid[v] = faceLid[remade.nearest[v]];
    for (int f = 0; f < mesh.faceCount(); ++f) {
      const int number = mesh.lid[mesh.faces(f, 0)];
      if (number == mesh.lid[mesh.faces(f, 1)] && number == mesh.lid[mesh.faces(f, 2)])
        mesh.faceLid[f] = number;
    }
    result.handles = static_cast<int>(remade.handles);
    result.voxelSize = remade.voxelSize;
    result.left = findingOf(mesh.vertices, mesh.faces, name);
    result.changed = true;
  }
  report(progress, 1);
  return resultOf(std::move(mesh), std::move(result));
}

}  // namespace sphere_propagation
