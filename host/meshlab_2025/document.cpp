#include "host/document.h"

#include <algorithm>
#include <utility>

namespace sphere_propagation::host {

std::vector<const MeshModel*> meshesOf(const MeshDocument& document) {
  std::vector<const MeshModel*> meshes;
  for (const MeshModel& mesh : document.meshIterator()) meshes.push_back(&mesh);
  return meshes;
}

std::optional<Points> pointAttribute(const CMeshO& mesh, const std::string& name) {
  return copyPointAttribute(mesh, name);
}

std::optional<Eigen::VectorXd> scalarAttribute(const CMeshO& mesh, const std::string& name) {
  return copyScalarAttribute(mesh, name);
}

void replaceMesh(MeshModel& layer, CMeshO&& mesh) {
  layer.cm = std::move(mesh);
  layer.updateBoxAndNormals();
  layer.updateDataMask();
}

void removeLayer(MeshDocument& document, int id) { document.delMesh(static_cast<unsigned int>(id)); }

void enableTextureCoordinates(MeshModel& layer) { layer.updateDataMask(MeshModel::MM_VERTTEXCOORD); }

void addLayerParameter(RichParameterList& list, const Parameter& p, const MeshDocument& document) {
  const int id = std::get<Parameter::LayerId>(p.value).id;
  list.addParam(RichMesh(qt(p.name), static_cast<unsigned int>(std::max(id, 0)), &document, qt(p.dialogLabel()),
                         qt(p.help), p.advanced));
}

int chosenLayerId(const RichParameterList& list, const std::string& name) {
  return static_cast<int>(list.getMeshId(qt(name)));
}

}  // namespace sphere_propagation::host
