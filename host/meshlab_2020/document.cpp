// SPDX-License-Identifier: GPL-3.0-only
#include "host/document.h"

#include <algorithm>
#include <utility>

#include "host/remedies.h"

namespace sphere_propagation::host {
namespace {

using Allocator = vcg::tri::Allocator<CMeshO>;

template <class Value>
std::vector<std::string> attributes(CMeshO& mesh) {
  std::vector<std::string> names;
  Allocator::GetAllPerVertexAttribute<Value>(mesh, names);
  return names;
}

/// Makes `mesh` have the attributes of this type that `model` has, and no others.
template <class Value>
void enableAttributesOf(CMeshO& model, CMeshO& mesh) {
  for (const std::string& name : attributes<Value>(mesh))
    Allocator::DeletePerVertexAttribute(mesh, name);
  for (const std::string& name : attributes<Value>(model))
    Allocator::AddPerVertexAttribute<Value>(mesh, name);
}

constexpr int always = MeshModel::MM_VERTCOORD | MeshModel::MM_VERTNORMAL | MeshModel::MM_VERTFLAG |
                       MeshModel::MM_FACEVERT | MeshModel::MM_FACENORMAL | MeshModel::MM_FACEFLAG;
// MeshLab makes these where it needs them.
constexpr int adjacency = MeshModel::MM_FACEFACETOPO | MeshModel::MM_VERTFACETOPO;

/// The same vertices, faces, components and attributes: meshes of this VCG can be copied only, and
/// only into what is there.
std::unique_ptr<CMeshO> copyOf(MeshModel& layer) {
  auto copy = std::make_unique<CMeshO>();
  if (layer.hasDataMask(MeshModel::MM_VERTTEXCOORD)) copy->vert.EnableTexCoord();
  if (layer.hasDataMask(MeshModel::MM_VERTMARK)) copy->vert.EnableMark();
  if (layer.hasDataMask(MeshModel::MM_VERTCURV)) copy->vert.EnableCurvature();
  if (layer.hasDataMask(MeshModel::MM_VERTCURVDIR)) copy->vert.EnableCurvatureDir();
  if (layer.hasDataMask(MeshModel::MM_VERTRADIUS)) copy->vert.EnableRadius();
  if (layer.hasDataMask(MeshModel::MM_FACECOLOR)) copy->face.EnableColor();
  if (layer.hasDataMask(MeshModel::MM_FACEQUALITY)) copy->face.EnableQuality();
  if (layer.hasDataMask(MeshModel::MM_FACEMARK)) copy->face.EnableMark();
  if (layer.hasDataMask(MeshModel::MM_FACECURVDIR)) copy->face.EnableCurvatureDir();
  if (layer.hasDataMask(MeshModel::MM_WEDGTEXCOORD)) copy->face.EnableWedgeTexCoord();
  enableAttributesOf<Point3m>(layer.cm, *copy);
  enableAttributesOf<Scalarm>(layer.cm, *copy);
  vcg::tri::Append<CMeshO, CMeshO>::MeshCopy(*copy, layer.cm);
  copy->svn = layer.cm.svn;
  copy->sfn = layer.cm.sfn;
  return copy;
}

/// mask: the components that the layer is to have.
void fillLayer(MeshModel& layer, CMeshO& mesh, int mask) {
  layer.clearDataMask(layer.dataMask() & ~always);
  layer.cm.Clear();
  layer.updateDataMask(mask & ~adjacency);
  enableAttributesOf<Point3m>(mesh, layer.cm);
  enableAttributesOf<Scalarm>(mesh, layer.cm);
  vcg::tri::Append<CMeshO, CMeshO>::MeshCopy(layer.cm, mesh);
  layer.cm.svn = mesh.svn;
  layer.cm.sfn = mesh.sfn;
  layer.UpdateBoxAndNormals();
}

}  // namespace

Host thisHost() { return Host::MeshLab2020; }

std::vector<const MeshModel*> meshesOf(const MeshDocument& document) {
  return {document.meshList.begin(), document.meshList.end()};
}

std::optional<Points> pointAttribute(const CMeshO& mesh, const std::string& name) {
  return copyPointAttribute(const_cast<CMeshO&>(mesh),
                            name);  // this VCG reads those of meshes that may change only
}

std::vector<std::string> pointAttributeNames(const CMeshO& mesh) {
  std::vector<std::string> names;  // VCG reads those of meshes that may change only
  vcg::tri::Allocator<CMeshO>::GetAllPerVertexAttribute<Point3m>(const_cast<CMeshO&>(mesh), names);
  return names;
}

std::optional<Eigen::VectorXd> scalarAttribute(const CMeshO& mesh, const std::string& name) {
  return copyScalarAttribute(const_cast<CMeshO&>(mesh), name);
}

FormerMesh replaceMesh(MeshModel& layer, std::unique_ptr<CMeshO> mesh) {
  FormerMesh former{copyOf(layer), layer.dataMask()};
  try {
    fillLayer(
        layer, *mesh,
        MeshModel::MM_VERTCOLOR | MeshModel::MM_VERTQUALITY);  // every mesh of this type has them
  } catch (...) {
    restoreMesh(layer, std::move(former));
    throw;
  }
  return former;
}

void restoreMesh(MeshModel& layer, FormerMesh former) {
  fillLayer(layer, *former.mesh, former.dataMask);
}

void updateBoxAndNormals(MeshModel& layer) { layer.UpdateBoxAndNormals(); }

void removeLayer(MeshDocument& document, int id) { document.delMesh(document.getMesh(id)); }

void enableTextureCoordinates(MeshModel& layer) {
  // meshlabserver -w takes a layer's data mask for a mask of file contents, in which the bit of
  // MM_VERTMARK means texture coordinates per vertex.
  static_assert(static_cast<int>(MeshModel::MM_VERTMARK) == 0x20);
  layer.updateDataMask(MeshModel::MM_VERTTEXCOORD | MeshModel::MM_VERTMARK);
}

void addLayerParameter(RichParameterList& list, const Parameter& p, const MeshDocument& document) {
  if (document.meshList.empty()) return;  // MeshLab's widget wants a layer to show
  // This MeshLab means places in the list, not ids, and takes no constant document, which it does
  // not change.
  const int id = std::get<Parameter::LayerId>(p.value).id;
  const auto begin = document.meshList.begin(), end = document.meshList.end();
  const auto found =
      std::find_if(begin, end, [id](const MeshModel* mesh) { return mesh->id() == id; });
  const auto place = static_cast<int>(found == end ? 0 : found - begin);
  list.addParam(RichMesh(qt(p.name), place, const_cast<MeshDocument*>(&document),
                         qt(p.dialogLabel()), qt(p.help)));
}

int chosenLayerId(const RichParameterList& list, const std::string& name) {
  if (!list.hasParameter(qt(name))) return -1;
  const MeshModel* mesh = list.getMesh(qt(name));
  return mesh != nullptr ? mesh->id() : -1;
}

}  // namespace sphere_propagation::host
