// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// MeshLab's documents and parameters under one name, where its versions differ: what layers.cpp,
/// changes.cpp and filter_set.cpp need of them. The folders meshlab_2025/ and meshlab_2020/ define
/// it; CMake compiles the host's.

#ifdef HOST_IS_MESHLAB_2020
#include <common/filter_parameter/rich_parameter_list.h>
#include <common/meshmodel.h>
using RichFileOpen = RichOpenFile;
using RichFileSave = RichSaveFile;
#else
#include <common/ml_document/mesh_document.h>
#include <common/parameters/rich_parameter_list.h>
#endif
#include <common/mlexception.h>

#include <cstring>  // callback.h of 2020.09 lacks it
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <wrap/callback.h>

#include "host/parameter.h"
#include "vcg_ext/base/matrices.h"

namespace sphere_propagation::host {

/// The meshes of a document, in layer order.
std::vector<const MeshModel*> meshesOf(const MeshDocument& document);

/// A per-vertex point attribute: one row per element of mesh.vert; nothing when the mesh has none
/// of this name.
std::optional<Points> pointAttribute(const CMeshO& mesh, const std::string& name);

/// The names of all per-vertex point attributes, in their order.
std::vector<std::string> pointAttributeNames(const CMeshO& mesh);

/// A per-vertex scalar attribute: one entry per element of mesh.vert; nothing when the mesh has
/// none of this name.
std::optional<Eigen::VectorXd> scalarAttribute(const CMeshO& mesh, const std::string& name);

/// The same for a mesh of either constness, for those who define them.
template <class Mesh>
std::optional<Points> copyPointAttribute(Mesh& mesh, const std::string& name) {
  using Allocator = vcg::tri::Allocator<CMeshO>;
  auto handle = Allocator::FindPerVertexAttribute<Point3m>(mesh, name);
  if (!Allocator::IsValidHandle(mesh, handle)) return std::nullopt;
  Points points(static_cast<Eigen::Index>(mesh.vert.size()), 3);
  for (size_t v = 0; v < mesh.vert.size(); ++v) {
    const Point3m& p = handle[v];
    points.row(static_cast<Eigen::Index>(v)) << p[0], p[1], p[2];
  }
  return points;
}

template <class Mesh>
std::optional<Eigen::VectorXd> copyScalarAttribute(Mesh& mesh, const std::string& name) {
  using Allocator = vcg::tri::Allocator<CMeshO>;
  auto handle = Allocator::FindPerVertexAttribute<Scalarm>(mesh, name);
  if (!Allocator::IsValidHandle(mesh, handle)) return std::nullopt;
  Eigen::VectorXd values(static_cast<Eigen::Index>(mesh.vert.size()));
  for (size_t v = 0; v < mesh.vert.size(); ++v) values[static_cast<Eigen::Index>(v)] = handle[v];
  return values;
}

/// What a layer held before.
struct FormerMesh {
  std::unique_ptr<CMeshO> mesh;
  int dataMask = 0;
};

/// Makes a layer hold what `mesh` holds (vertices, faces, colours, point and scalar attributes) and
/// nothing else, and updates normals, box and data mask. The layer's matrix, label and visibility
/// stay. Where memory runs out the layer is as it was (in 2020.09, whose meshes can only be copied,
/// as far as there is memory to copy back), and std::bad_alloc is thrown.
FormerMesh replaceMesh(MeshModel& layer, std::unique_ptr<CMeshO> mesh);

/// Puts back what replaceMesh returned.
void restoreMesh(MeshModel& layer, FormerMesh former);

/// After vertices were moved or faces turned.
void updateBoxAndNormals(MeshModel& layer);

/// Takes a layer off the document.
void removeLayer(MeshDocument& document, int id);

/// Gives a layer texture coordinates per vertex, such that every way of saving it keeps them.
void enableTextureCoordinates(MeshModel& layer);

/// Adds a choice among the document's layers.
void addLayerParameter(RichParameterList& list, const Parameter& parameter,
                       const MeshDocument& document);

/// The id of the layer that was chosen, -1 when there was none to choose.
int chosenLayerId(const RichParameterList& list, const std::string& name);

inline QString qt(const std::string& s) { return QString::fromStdString(s); }

/// Adds a parameter of any other kind. value: what the constructor of the RichParameter takes after
/// the name.
template <class Rich, class... Value>
void addRichParameter(RichParameterList& list, const Parameter& p, Value... value) {
#ifdef HOST_IS_MESHLAB_2020  // it has no advanced parameters
  list.addParam(Rich(qt(p.name), value..., qt(p.dialogLabel()), qt(p.help)));
#else
  list.addParam(Rich(qt(p.name), value..., qt(p.dialogLabel()), qt(p.help), p.advanced));
#endif
}

}  // namespace sphere_propagation::host
