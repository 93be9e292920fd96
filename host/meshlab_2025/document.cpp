// SPDX-License-Identifier: GPL-3.0-only
#include "host/document.h"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "host/remedies.h"

namespace sphere_propagation::host {
namespace {

/// An attribute refers to the vertices that it was made for, and a mesh that is moved does not tell
/// it that they are now another mesh's: MeshLab's own filters would read freed memory. So it is
/// made again.
template <class Value>
void renewAttributes(CMeshO& mesh) {
  using Allocator = vcg::tri::Allocator<CMeshO>;
  std::vector<std::string> names;
  Allocator::GetAllPerVertexAttribute<Value>(mesh, names);
  for (const std::string& name : names) {
    auto old = Allocator::FindPerVertexAttribute<Value>(mesh, name);
    std::vector<Value> values;
    values.reserve(mesh.vert.size());
    for (size_t v = 0; v < mesh.vert.size(); ++v) values.push_back(old[v]);
    Allocator::DeletePerVertexAttribute(mesh, name);
    auto renewed = Allocator::AddPerVertexAttribute<Value>(mesh, name);
    for (size_t v = 0; v < values.size(); ++v) renewed[v] = values[v];
  }
}

}  // namespace

Host thisHost() { return std::is_same_v<Scalarm, double> ? Host::PyMeshLab : Host::MeshLab2025; }

std::vector<const MeshModel*> meshesOf(const MeshDocument& document) {
  std::vector<const MeshModel*> meshes;
  for (const MeshModel& mesh : document.meshIterator()) meshes.push_back(&mesh);
  return meshes;
}

std::optional<Points> pointAttribute(const CMeshO& mesh, const std::string& name) {
  return copyPointAttribute(mesh, name);
}

std::vector<std::string> pointAttributeNames(const CMeshO& mesh) {
  std::vector<std::string> names;  // VCG reads those of meshes that may change only
  vcg::tri::Allocator<CMeshO>::GetAllPerVertexAttribute<Point3m>(const_cast<CMeshO&>(mesh), names);
  return names;
}

std::optional<Eigen::VectorXd> scalarAttribute(const CMeshO& mesh, const std::string& name) {
  return copyScalarAttribute(mesh, name);
}

FormerMesh replaceMesh(MeshModel& layer, std::unique_ptr<CMeshO> mesh) {
  FormerMesh former{std::move(mesh), layer.dataMask()};
  swap(layer.cm, *former.mesh);
  try {
    renewAttributes<Point3m>(layer.cm);
    renewAttributes<Scalarm>(layer.cm);
  } catch (...) {
    restoreMesh(layer, std::move(former));
    throw;
  }
  layer.updateBoxAndNormals();
  layer.updateDataMask();
  return former;
}

void restoreMesh(MeshModel& layer, FormerMesh former) {
  swap(layer.cm, *former.mesh);  // whose attributes refer to this layer's vertices, as before
  layer.updateDataMask();
}

void updateBoxAndNormals(MeshModel& layer) { layer.updateBoxAndNormals(); }

void removeLayer(MeshDocument& document, int id) {
  document.delMesh(static_cast<unsigned int>(id));
}

void enableTextureCoordinates(MeshModel& layer) {
  layer.updateDataMask(MeshModel::MM_VERTTEXCOORD);
}

void addLayerParameter(RichParameterList& list, const Parameter& p, const MeshDocument& document) {
  const int id = std::get<Parameter::LayerId>(p.value).id;
  list.addParam(RichMesh(qt(p.name), static_cast<unsigned int>(std::max(id, 0)), &document,
                         qt(p.dialogLabel()), qt(p.help), p.advanced));
}

int chosenLayerId(const RichParameterList& list, const std::string& name) {
  return static_cast<int>(list.getMeshId(qt(name)));
}

}  // namespace sphere_propagation::host
