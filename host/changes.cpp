#include "host/changes.h"

#include <QRegularExpression>
#include <algorithm>
#include <utility>

#include "host/document.h"
#include "vcg_ext/map/certificate.h"
#include "vcg_ext/map/texture_copy.h"

namespace sphere_propagation::host {
namespace {

using Allocator = vcg::tri::Allocator<CMeshO>;

Point3m pointm(const Points& points, Eigen::Index row) {
  return {static_cast<Scalarm>(points(row, 0)), static_cast<Scalarm>(points(row, 1)),
          static_cast<Scalarm>(points(row, 2))};
}

std::unique_ptr<CMeshO> makeMesh(const NewLayer& layer) {
  auto mesh = std::make_unique<CMeshO>();
  meshFromSurface(layer.vertices, layer.faces, *mesh);
  if (layer.colors)
    for (int v = 0; v < mesh->vn; ++v)
      mesh->vert[v].C() = vcg::Color4b((*layer.colors)(v, 0), (*layer.colors)(v, 1), (*layer.colors)(v, 2), 255);
  for (const auto& [name, values] : layer.pointAttributes) {
    auto handle = Allocator::AddPerVertexAttribute<Point3m>(*mesh, name);
    for (int v = 0; v < mesh->vn; ++v) handle[static_cast<size_t>(v)] = pointm(values, v);
  }
  return mesh;
}

/// A label without the "(1)" that MeshLab appends to the second layer of a name.
QString withoutNumber(const QString& label) {
  static const QRegularExpression number("\\(\\d+\\)$");
  return QString(label).remove(number);
}

}  // namespace

struct Changes::MapChange {
  int layerId;
  std::vector<int> meshVertex;
  std::vector<Point3m> positions;
  std::optional<TextureCopy> texture;
};

struct Changes::LayerChange {
  std::string label;
  int replacedId;  // -1: a new layer
  std::unique_ptr<CMeshO> mesh;
};

Changes::Changes(MeshDocument& document) : document_(document) {}
Changes::~Changes() = default;

std::string Changes::setMap(const Layer& layer, const MeshSurface& surface, const SphereMap& map) {
  MapChange change{layer.id(), surface.meshVertex, {}, copyToTexture(surface.surface, map)};
  change.positions.reserve(surface.meshVertex.size());
  for (Eigen::Index v = 0; v < map.positions().rows(); ++v) change.positions.push_back(pointm(map.positions(), v));
  std::string note;
  if (!change.texture->valid) {
    change.texture.reset();
    note = "Layer \"" + layer.label() +
           "\": its map is too fine for texture coordinates, which are stored as float; it is kept as the attribute "
           "\"sphere_position\" only, which files do not keep.";
  } else if (change.texture->mendedVertices > 0) {
    note = "Layer \"" + layer.label() + "\": " + std::to_string(change.texture->mendedVertices) +
           " texture coordinates were moved by a few units in the last place, so that the map stays valid as float.";
  }
  maps_.push_back(std::move(change));
  return note;
}

void Changes::addLayer(const NewLayer& layer) {
  const auto taken = [this](int id) {
    return std::any_of(layers_.begin(), layers_.end(), [id](const LayerChange& c) { return c.replacedId == id; });
  };
  int replaced = -1;
  for (const MeshModel* mesh : meshesOf(document_))
    if (replaced < 0 && !taken(mesh->id()) && withoutNumber(mesh->label()) == qt(layer.label) &&
        Layer(*mesh).kind() == layer.kind)
      replaced = mesh->id();
  layers_.push_back({layer.label, replaced, makeMesh(layer)});
}

void Changes::commit() {
  for (MapChange& change : maps_) {
    MeshModel& mesh = *document_.getMesh(static_cast<unsigned int>(change.layerId));
    auto handle = Allocator::GetPerVertexAttribute<Point3m>(mesh.cm, spherePositionAttribute);
    for (size_t v = 0; v < change.meshVertex.size(); ++v)
      handle[static_cast<size_t>(change.meshVertex[v])] = change.positions[v];
    if (change.texture) {
      mesh.updateDataMask(MeshModel::MM_VERTTEXCOORD);
      for (size_t v = 0; v < change.meshVertex.size(); ++v) {
        auto& t = mesh.cm.vert[static_cast<size_t>(change.meshVertex[v])].T();
        t.U() = change.texture->coordinates(static_cast<Eigen::Index>(v), 0);
        t.V() = change.texture->coordinates(static_cast<Eigen::Index>(v), 1);
        t.N() = 0;
      }
    } else if (mesh.hasDataMask(MeshModel::MM_VERTTEXCOORD)) {
      mesh.clearDataMask(MeshModel::MM_VERTTEXCOORD);  // they would be those of an earlier map
    }
    mesh.setMeshModified();
  }
  bool first = true;
  for (LayerChange& change : layers_) {
    MeshModel* mesh = change.replacedId >= 0 ? document_.getMesh(static_cast<unsigned int>(change.replacedId))
                                             : document_.addNewMesh("", qt(change.label), false);
    replaceMesh(*mesh, std::move(*change.mesh));
    mesh->cm.Tr.SetIdentity();
    mesh->setMeshModified();
    if (first && (firstBecomesCurrent_ || document_.mm() == nullptr)) document_.setCurrentMesh(mesh->id());
    first = false;
  }
}

}  // namespace sphere_propagation::host
