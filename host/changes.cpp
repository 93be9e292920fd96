// SPDX-License-Identifier: GPL-3.0-only
#include "host/changes.h"

#include <Eigen/Geometry>
#include <QRegularExpression>
#include <algorithm>
#include <new>
#include <type_traits>
#include <utility>

#include "host/document.h"
#include "host/messages.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/base/fingerprint.h"
#include "vcg_ext/sphere/repair/float_copy.h"

namespace sphere_propagation::host {
namespace {

using Allocator = vcg::tri::Allocator<CMeshO>;

Point3m pointm(const Points& points, Eigen::Index row) {
  return {static_cast<Scalarm>(points(row, 0)), static_cast<Scalarm>(points(row, 1)),
          static_cast<Scalarm>(points(row, 2))};
}

/// The mesh has the attribute.
void markMesh(CMeshO& mesh, const std::string& name, int value) {
  auto handle = Allocator::FindPerVertexAttribute<Scalarm>(mesh, name);
  for (size_t v = 0; v < mesh.vert.size(); ++v) handle[v] = static_cast<Scalarm>(value);
}

/// The same point for all vertices. The mesh has the attribute.
void fillAttribute(CMeshO& mesh, const std::string& name, const Vector3& value) {
  auto handle = Allocator::FindPerVertexAttribute<Point3m>(mesh, name);
  for (size_t v = 0; v < mesh.vert.size(); ++v)
    for (int k = 0; k < 3; ++k) handle[v][k] = static_cast<Scalarm>(value[k]);
}

std::unique_ptr<CMeshO> makeMesh(const NewLayer& layer) {
  auto mesh = std::make_unique<CMeshO>();
  meshFromSurface(layer.vertices, layer.faces, *mesh);
  if (layer.colors)
    for (int v = 0; v < mesh->vn; ++v)
      mesh->vert[v].C() =
          vcg::Color4b((*layer.colors)(v, 0), (*layer.colors)(v, 1), (*layer.colors)(v, 2), 255);
  if (layer.quality)
    for (int v = 0; v < mesh->vn; ++v)
      mesh->vert[v].Q() = static_cast<Scalarm>((*layer.quality)[v]);
  for (const auto& [name, values] : layer.pointAttributes) {
    auto handle = Allocator::AddPerVertexAttribute<Point3m>(*mesh, name);
    for (int v = 0; v < mesh->vn; ++v) handle[static_cast<size_t>(v)] = pointm(values, v);
  }
  for (const auto& [name, values] : layer.scalarAttributes) {
    auto handle = Allocator::AddPerVertexAttribute<Scalarm>(*mesh, name);
    for (int v = 0; v < mesh->vn; ++v)
      handle[static_cast<size_t>(v)] = static_cast<Scalarm>(values[v]);
  }
  mesh->svn = mesh->sfn = 0;
  if (!layer.selectedVertices.empty())
    for (int v = 0; v < mesh->vn; ++v)
      if (layer.selectedVertices[v]) mesh->vert[v].SetS(), ++mesh->svn;
  if (!layer.selectedFaces.empty())
    for (int f = 0; f < mesh->fn; ++f)
      if (layer.selectedFaces[f]) mesh->face[f].SetS(), ++mesh->sfn;
  for (const auto& [name, value] : layer.marks) {
    Allocator::AddPerVertexAttribute<Scalarm>(*mesh, name);
    markMesh(*mesh, name, value);
  }
  return mesh;
}

void setMatrix(CMeshO& mesh, const Eigen::Matrix4d& matrix) {
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      mesh.Tr.ElementAt(row, column) = static_cast<Scalarm>(matrix(row, column));
}

/// Exchanges corners 1 and 2, and so the sides 0 and 2.
void turn(CFaceO& face, bool hasTexture) {
  std::swap(face.V(1), face.V(2));
  if (hasTexture) std::swap(face.WT(1), face.WT(2));
  const bool first = face.IsF(0),
             last = face.IsF(2);  // sides that are drawn, or lie inside a polygon
  last ? face.SetF(0) : face.ClearF(0);
  first ? face.SetF(2) : face.ClearF(2);
}

std::vector<std::string> anchorAttributesOf(const CMeshO& mesh) {
  std::vector<std::string> names;
  for (const std::string& name : pointAttributeNames(mesh))
    if (name.rfind(anchorAttributePrefix, 0) == 0) names.push_back(name);
  return names;
}

void mirrorLayer(MeshModel& layer, double plane) {
  CMeshO& mesh = layer.cm;
  Eigen::Matrix4d reflection = Eigen::Matrix4d::Identity();
  reflection(0, 0) = -1;
  reflection(0, 3) = 2 * plane;
  const Eigen::Matrix4d matrix = Layer(layer).matrix();
  Eigen::Matrix4d ofVertices = matrix.inverse() * reflection * matrix;
  if (!ofVertices.allFinite()) {
    ofVertices = reflection * matrix;
    setMatrix(mesh, Eigen::Matrix4d::Identity());
    Allocator::DeletePerVertexAttribute(mesh, inPlaceAttribute);
    Allocator::DeletePerVertexAttribute(mesh, asideAttribute);
  }
  const Eigen::Matrix3d linear = ofVertices.topLeftCorner<3, 3>();
  const Vector3 shift = ofVertices.topRightCorner<3, 1>();
  const auto moved = [&](const Point3m& p, const Vector3& by) -> Point3m {
    const Vector3 q = linear * Vector3(p[0], p[1], p[2]) + by;
    return {static_cast<Scalarm>(q[0]), static_cast<Scalarm>(q[1]), static_cast<Scalarm>(q[2])};
  };
  const bool hasDirections = layer.hasDataMask(MeshModel::MM_VERTCURVDIR);
  for (CVertexO& v : mesh.vert) {
    if (v.IsD()) continue;
    v.P() = moved(v.cP(), shift);
    if (!hasDirections) continue;
    v.PD1() = moved(v.cPD1(), Vector3::Zero());
    v.PD2() = moved(v.cPD2(), Vector3::Zero());
  }
  for (const std::string& attribute : anchorAttributesOf(mesh)) {
    auto handle = Allocator::FindPerVertexAttribute<Point3m>(mesh, attribute);
    for (size_t v = 0; v < mesh.vert.size(); ++v) handle[v] = moved(handle[v], shift);
  }
  layer.clearDataMask(MeshModel::MM_FACEFACETOPO |
                      MeshModel::MM_VERTFACETOPO);  // MeshLab makes them where it needs them
  const bool hasTexture = layer.hasDataMask(MeshModel::MM_WEDGTEXCOORD);
  for (CFaceO& face : mesh.face)
    if (!face.IsD()) turn(face, hasTexture);
  updateBoxAndNormals(layer);
  layer.setMeshModified();
}

/// Takes components away, also where making them failed half way.
void disable(MeshModel& layer, int mask) {
  if ((mask & MeshModel::MM_VERTTEXCOORD) != 0) layer.cm.vert.DisableTexCoord();
  if ((mask & MeshModel::MM_VERTMARK) != 0) layer.cm.vert.DisableMark();
  if ((mask & MeshModel::MM_FACEQUALITY) != 0) layer.cm.face.DisableQuality();
  layer.clearDataMask(mask);
}

/// Stands for what is stored, as Layer::mapFingerprint tells it afterwards.
int fingerprintOf(const std::vector<Point3m>& positions, const std::optional<TextureCopy>& texture,
                  const Triangles& faces) {
  Fingerprint fingerprint;
  for (const Point3m& p : positions)
    for (int k = 0; k < 3; ++k) fingerprint.add(static_cast<double>(p[k]));
  if (positions.empty())
    for (Eigen::Index v = 0; v < texture->numbers.rows(); ++v)
      for (int k = 0; k < 2; ++k) fingerprint.add(static_cast<double>(texture->numbers(v, k)));
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) fingerprint.add(faces(f, k));
  return fingerprint.short24();
}

/// A label without the "(1)" that MeshLab appends to the second layer of a name.
QString withoutNumber(const QString& label) {
  static const QRegularExpression number("\\(\\d+\\)$");
  return QString(label).remove(number);
}

// MeshLab 2025.07 draws a mesh of as many faces as before with the places and normals that it had,
// unless each is said to have changed.
constexpr int wholeMesh = MeshModel::MM_VERTCOORD | MeshModel::MM_VERTNORMAL |
                          MeshModel::MM_FACENORMAL | MeshModel::MM_FACEVERT;

}  // namespace

struct Changes::MapChange {
  int layerId;
  std::vector<int> meshVertex;
  std::vector<Point3m> positions;  // empty: they do not hold the map
  std::optional<TextureCopy> texture;
  int root;
};

struct Changes::MirrorChange {
  int layerId;
  double plane;
};

struct Changes::ColorChange {
  int layerId;
  std::vector<int> meshVertex;
  Colors colors;
};

struct Changes::QualityChange {
  int layerId;
  std::vector<int> meshVertex;
  Eigen::VectorXd ofVertices;
  std::optional<Eigen::VectorXd> ofFaces;
};

struct Changes::MarkChange {
  int layerId;
  std::string name;
  int value;
};

struct Changes::AnchorChange {
  int layerId;
  AnchorSet anchors;  // by attribute, as stored
  std::vector<std::string> gone;
};

struct Changes::PlaceChange {
  int layerId;
  Vector3 inPlace;
  std::optional<Vector3> aside;  // nothing: in its place again
};

struct Changes::LayerChange {
  std::string label;
  int replacedId;  // -1: a new layer
  std::unique_ptr<CMeshO> mesh;
  Eigen::Matrix4d matrix;
};

Changes::Changes(MeshDocument& document) : document_(document) {}
Changes::~Changes() = default;

std::optional<Remark> Changes::setMap(const Layer& layer, const MeshSurface& surface,
                                      const MappedSurface& map, std::optional<int> root) {
  MapChange change{layer.id(), surface.meshVertex, {}, copyToTexture(map), 0};
  int mended = change.texture->mendedVertices;
  const bool textureHoldsIt = change.texture->valid;
  if (!textureHoldsIt) {
    mended = 0;
    change.texture.reset();
  }
  bool attributeHoldsIt = true;
  if constexpr (std::is_same_v<Scalarm, double>) {
    for (Eigen::Index v = 0; v < map.positions().rows(); ++v)
      change.positions.push_back(pointm(map.positions(), v));
  } else {
    const PositionCopy copy = copyToFloat(map);
    attributeHoldsIt = copy.valid;
    if (copy.valid) {
      mended += copy.mendedVertices;
      const Points rounded = copy.numbers.cast<double>();
      for (Eigen::Index v = 0; v < rounded.rows(); ++v)
        change.positions.push_back(pointm(rounded, v));
    }
  }
  if (!textureHoldsIt && !attributeHoldsIt) throw Refusal(messages::mapNotStored, layer.label());
  // What stands for a map stands for what is stored, so that it can be told again from the layer.
  change.root =
      root ? *root : fingerprintOf(change.positions, change.texture, surface.surface.faces());
  maps_.push_back(std::move(change));
  if (!textureHoldsIt) return remarkOn(layer.label(), messages::mapNotInFiles);
  if (!attributeHoldsIt) return remarkOn("", messages::mapNotInAttribute, layer.label());
  if (mended > 0) return remarkOn("", messages::verticesMoved, layer.label(), mended);
  return {};
}

std::optional<int> Changes::rootOfMapOn(const Layer& layer) const {
  for (auto change = maps_.rbegin(); change != maps_.rend(); ++change)
    if (change->layerId == layer.id()) return change->root;
  return std::nullopt;
}

void Changes::setMark(const Layer& layer, const char* name, int value) {
  marks_.push_back({layer.id(), name, value});
}

void Changes::setAnchors(const Layer& layer, const AnchorSet& anchors) {
  AnchorChange change{layer.id(), {}, {}};
  for (const auto& [name, place] : transformed(anchors, layer.matrix().inverse()))
    if (place.allFinite()) change.anchors.emplace(anchorAttribute(name), place);
  for (const auto& [name, place] : layer.anchors())
    if (change.anchors.count(anchorAttribute(name)) == 0)
      change.gone.push_back(anchorAttribute(name));
  anchors_.push_back(std::move(change));
}

void Changes::mirror(const Layer& layer, double plane) { mirrors_.push_back({layer.id(), plane}); }

void Changes::setColors(const Layer& layer, const MeshSurface& surface, Colors colors) {
  colors_.push_back({layer.id(), surface.meshVertex, std::move(colors)});
}

void Changes::setQuality(const Layer& layer, const MeshSurface& surface, Eigen::VectorXd ofVertices,
                         std::optional<Eigen::VectorXd> ofFaces) {
  qualities_.push_back({layer.id(), surface.meshVertex, std::move(ofVertices), std::move(ofFaces)});
}

void Changes::showAside(const Layer& layer, const Vector3& move) {
  const MeshModel& mesh = *document_.getMesh(static_cast<unsigned int>(layer.id()));
  const Vector3 shown = matrixFromVcg(mesh.cm.Tr).topRightCorner<3, 1>();
  places_.push_back({layer.id(), layer.matrix().topRightCorner<3, 1>(), Vector3(shown + move)});
}

void Changes::showInPlace(const Layer& layer) {
  places_.push_back({layer.id(), layer.matrix().topRightCorner<3, 1>(), std::nullopt});
}

bool Changes::addLayer(const NewLayer& given) {
  NewLayer shifted;
  if (given.aside) {
    shifted = given;
    const Vector3 inPlace = given.matrix.topRightCorner<3, 1>(), aside = inPlace + *given.aside;
    const Eigen::Index count = given.vertices.rows();
    shifted.pointAttributes[inPlaceAttribute] = inPlace.transpose().replicate(count, 1);
    shifted.pointAttributes[asideAttribute] = aside.transpose().replicate(count, 1);
    shifted.matrix.topRightCorner<3, 1>() = aside;
  }
  const NewLayer& layer = given.aside ? shifted : given;
  const auto taken = [this](int id) {
    return std::any_of(layers_.begin(), layers_.end(),
                       [id](const LayerChange& c) { return c.replacedId == id; });
  };
  const auto label = [&](const MeshModel& mesh) {
    return layer.kind == LayerKind::Model ? withoutNumber(mesh.label()).toStdString()
                                          : Layer(mesh).plainLabel();
  };
  int replaced = layer.replacedId.value_or(-1);
  for (const MeshModel* mesh : meshesOf(document_))
    if (replaced < 0 && !taken(mesh->id()) && label(*mesh) == layer.label &&
        Layer(*mesh).kind() == layer.kind)
      replaced = mesh->id();
  layers_.push_back({layer.label, replaced, makeMesh(layer), layer.matrix});
  return replaced >= 0;
}

void Changes::remakeMesh(const Layer& layer, const MeshContent& former, RemadeMesh mesh) {
  const MeshModel& model = *document_.getMesh(static_cast<unsigned int>(layer.id()));
  const CMeshO& old = model.cm;
  NewLayer made;
  made.label = layer.label();
  made.replacedId = layer.id();
  made.matrix = layer.matrix();
  const Vector3 shown = matrixFromVcg(old.Tr).topRightCorner<3, 1>();
  if (layer.isShownAside()) made.aside = shown - made.matrix.topRightCorner<3, 1>();
  const Eigen::Matrix4d inverse = made.matrix.inverse();
  const bool isInvertible = inverse.allFinite();
  if (!isInvertible) made.matrix = Eigen::Matrix4d::Identity();
  const auto formerVertex = [&](Eigen::Index v) -> const CVertexO* {
    const int source = mesh.source[static_cast<size_t>(v)];
    return source < 0 ? nullptr : &old.vert[static_cast<size_t>(former.meshVertex[source])];
  };
  const Eigen::Index count = mesh.vertices.rows();
  made.vertices = mesh.vertices;
  for (Eigen::Index v = 0; isInvertible && v < count; ++v) {
    if (const CVertexO* p = formerVertex(v))
      made.vertices.row(v) << p->cP()[0], p->cP()[1], p->cP()[2];
    else
      made.vertices.row(v) =
          (inverse * mesh.vertices.row(v).transpose().homogeneous()).head<3>().transpose();
  }
  made.faces = mesh.faces;
  if (isInvertible && made.matrix.topLeftCorner<3, 3>().determinant() < 0)
    made.faces.col(1).swap(made.faces.col(2));
  if (model.hasDataMask(MeshModel::MM_VERTCOLOR)) {
    constexpr int grey = 160;
    made.colors = Colors::Constant(count, 3, grey);
    for (Eigen::Index v = 0; v < count; ++v)
      if (const CVertexO* p = formerVertex(v))
        made.colors->row(v) << p->cC()[0], p->cC()[1], p->cC()[2];
  }
  if (model.hasDataMask(MeshModel::MM_VERTQUALITY)) {
    made.quality = Eigen::VectorXd::Zero(count);
    for (Eigen::Index v = 0; v < count; ++v)
      if (const CVertexO* p = formerVertex(v)) (*made.quality)[v] = static_cast<double>(p->cQ());
  }
  for (const std::string& attribute : anchorAttributesOf(old))
    if (old.vn > 0 && isInvertible) {
      const auto places = pointAttribute(old, attribute);
      const auto first = std::find_if(old.vert.begin(), old.vert.end(),
                                      [](const CVertexO& v) { return !v.IsD(); });
      made.pointAttributes[attribute] = places->row(first - old.vert.begin()).replicate(count, 1);
    }
  made.scalarAttributes = std::move(mesh.scalarAttributes);
  made.selectedVertices = std::move(mesh.selectedVertices);
  made.selectedFaces = std::move(mesh.selectedFaces);
  addLayer(made);
}

void Changes::removeOtherLayers(LayerKind kind) {
  for (const MeshModel* mesh : meshesOf(document_)) {
    const bool replaced =
        std::any_of(layers_.begin(), layers_.end(),
                    [mesh](const LayerChange& change) { return change.replacedId == mesh->id(); });
    const Layer layer(*mesh);
    if (!replaced && layer.kind() == kind && !layer.hasFileName())
      removedIds_.push_back(mesh->id());
  }
}

/// All of a commit that takes memory; taken back unless it is kept.
class Changes::Preparation {
 public:
  explicit Preparation(Changes& changes)
      : changes_(changes),
        document_(changes.document_),
        current_(document_.mm() != nullptr ? document_.mm()->id() : -1) {
    size_t anchors = 0;
    for (const AnchorChange& change : changes.anchors_) anchors += change.anchors.size();
    made_.reserve(2 * changes.maps_.size() + changes.marks_.size() + 2 * changes.places_.size() +
                  anchors);
    enabled_.reserve(changes.maps_.size() + changes.qualities_.size());
    written_.reserve(changes.layers_.size());
  }
  ~Preparation() {
    if (!kept_) takeBack();
  }
  Preparation(const Preparation&) = delete;
  Preparation& operator=(const Preparation&) = delete;

  void makeRoom() {
    for (const MapChange& change : changes_.maps_) {
      MeshModel& mesh = layer(change.layerId);
      if (!change.positions.empty()) make<Point3m>(mesh, spherePositionAttribute);
      make<Scalarm>(mesh, rootMark);
      if (!change.texture) continue;
      willEnable(mesh, MeshModel::MM_VERTTEXCOORD | MeshModel::MM_VERTMARK);
      enableTextureCoordinates(mesh);
    }
    for (const MarkChange& change : changes_.marks_)
      make<Scalarm>(layer(change.layerId), change.name);
    for (const AnchorChange& change : changes_.anchors_)
      for (const auto& [attribute, place] : change.anchors)
        make<Point3m>(layer(change.layerId), attribute);
    for (const PlaceChange& change : changes_.places_) {
      if (!change.aside) continue;
      make<Point3m>(layer(change.layerId), inPlaceAttribute);
      make<Point3m>(layer(change.layerId), asideAttribute);
    }
    for (const QualityChange& change : changes_.qualities_) {
      if (!change.ofFaces) continue;
      MeshModel& mesh = layer(change.layerId);
      willEnable(mesh, MeshModel::MM_FACEQUALITY);
      mesh.updateDataMask(MeshModel::MM_FACEQUALITY);
    }
  }

  void writeLayers() {
    for (LayerChange& change : changes_.layers_) {
      const bool isNew = change.replacedId < 0;
      MeshModel& mesh =
          isNew ? *document_.addNewMesh("", qt(change.label), false) : layer(change.replacedId);
      written_.push_back({&mesh, isNew, {}});
      written_.back().former = replaceMesh(mesh, std::move(change.mesh));
    }
  }

  /// The layers that were written, in the order of the changes.
  MeshModel& written(size_t i) const { return *written_[i].layer; }
  void keep() { kept_ = true; }

 private:
  struct Made {
    MeshModel* layer;
    std::string attribute;
  };
  struct Enabled {
    MeshModel* layer;
    int mask;
  };
  struct Written {
    MeshModel* layer;
    bool isNew;
    FormerMesh former;
  };

  MeshModel& layer(int id) const { return *document_.getMesh(static_cast<unsigned int>(id)); }

  template <class Value>
  void make(MeshModel& mesh, const std::string& name) {
    if (Allocator::IsValidHandle(mesh.cm, Allocator::FindPerVertexAttribute<Value>(mesh.cm, name)))
      return;
    made_.push_back({&mesh, name});
    Allocator::AddPerVertexAttribute<Value>(mesh.cm, name);
  }

  void willEnable(MeshModel& mesh, int mask) {
    enabled_.push_back({&mesh, mask & ~mesh.dataMask()});
  }

  void takeBack() {
    for (auto w = written_.rbegin(); w != written_.rend(); ++w) {
      if (w->isNew) {
        host::removeLayer(document_, w->layer->id());
      } else if (w->former.mesh) {
        try {
          restoreMesh(*w->layer, std::move(w->former));
        } catch (const std::bad_alloc&) {  // 2020.09 alone: the others come first
        }
      }
    }
    for (const Enabled& e : enabled_) disable(*e.layer, e.mask);
    for (const Made& m : made_) Allocator::DeletePerVertexAttribute(m.layer->cm, m.attribute);
    if (Layers(document_).find(current_)) document_.setCurrentMesh(current_);
  }

  Changes& changes_;
  MeshDocument& document_;
  int current_;
  std::vector<Made> made_;
  std::vector<Enabled> enabled_;
  std::vector<Written> written_;
  bool kept_ = false;
};

int Changes::commit() {
  Preparation preparation(*this);
  preparation.makeRoom();
  preparation.writeLayers();
  preparation.keep();
  // Nothing from here on takes memory.
  int changed = MeshModel::MM_NONE;
  for (const MirrorChange& change : mirrors_) {
    mirrorLayer(*document_.getMesh(static_cast<unsigned int>(change.layerId)), change.plane);
    changed |= wholeMesh;
  }
  for (MapChange& change : maps_) {
    MeshModel& mesh = *document_.getMesh(static_cast<unsigned int>(change.layerId));
    if (change.positions.empty()) {
      Allocator::DeletePerVertexAttribute(
          mesh.cm, spherePositionAttribute);  // it would be that of an earlier map
    } else {
      auto handle = Allocator::FindPerVertexAttribute<Point3m>(mesh.cm, spherePositionAttribute);
      for (size_t v = 0; v < change.meshVertex.size(); ++v)
        handle[static_cast<size_t>(change.meshVertex[v])] = change.positions[v];
    }
    if (change.texture) {
      for (size_t v = 0; v < change.meshVertex.size(); ++v) {
        auto& t = mesh.cm.vert[static_cast<size_t>(change.meshVertex[v])].T();
        t.U() = change.texture->numbers(static_cast<Eigen::Index>(v), 0);
        t.V() = change.texture->numbers(static_cast<Eigen::Index>(v), 1);
        t.N() = 0;
      }
    } else if (mesh.hasDataMask(MeshModel::MM_VERTTEXCOORD)) {
      mesh.clearDataMask(MeshModel::MM_VERTTEXCOORD);  // they would be those of an earlier map
    }
    markMesh(mesh.cm, rootMark, change.root);
    mesh.setMeshModified();
    changed |= MeshModel::MM_VERTTEXCOORD;
  }
  for (const MarkChange& change : marks_)
    markMesh(document_.getMesh(static_cast<unsigned int>(change.layerId))->cm, change.name,
             change.value);
  for (const AnchorChange& change : anchors_) {
    CMeshO& mesh = document_.getMesh(static_cast<unsigned int>(change.layerId))->cm;
    for (const std::string& attribute : change.gone)
      Allocator::DeletePerVertexAttribute(mesh, attribute);
    for (const auto& [attribute, place] : change.anchors) fillAttribute(mesh, attribute, place);
  }
  for (const PlaceChange& change : places_) {
    MeshModel& mesh = *document_.getMesh(static_cast<unsigned int>(change.layerId));
    if (change.aside) {
      fillAttribute(mesh.cm, inPlaceAttribute, change.inPlace);
      fillAttribute(mesh.cm, asideAttribute, *change.aside);
    } else {
      Allocator::DeletePerVertexAttribute(mesh.cm, inPlaceAttribute);
      Allocator::DeletePerVertexAttribute(mesh.cm, asideAttribute);
    }
    const Vector3& to = change.aside ? *change.aside : change.inPlace;
    for (int k = 0; k < 3; ++k) mesh.cm.Tr.ElementAt(k, 3) = static_cast<Scalarm>(to[k]);
    mesh.setMeshModified();
    changed |= MeshModel::MM_TRANSFMATRIX;
  }
  for (const ColorChange& change : colors_) {
    MeshModel& mesh = *document_.getMesh(static_cast<unsigned int>(change.layerId));
    mesh.updateDataMask(MeshModel::MM_VERTCOLOR);
    for (size_t v = 0; v < change.meshVertex.size(); ++v) {
      const auto row = change.colors.row(static_cast<Eigen::Index>(v));
      mesh.cm.vert[static_cast<size_t>(change.meshVertex[v])].C() =
          vcg::Color4b(row[0], row[1], row[2], 255);
    }
    mesh.setMeshModified();
    changed |= MeshModel::MM_VERTCOLOR;
  }
  for (const QualityChange& change : qualities_) {
    MeshModel& mesh = *document_.getMesh(static_cast<unsigned int>(change.layerId));
    mesh.updateDataMask(MeshModel::MM_VERTQUALITY);
    for (size_t v = 0; v < change.meshVertex.size(); ++v)
      mesh.cm.vert[static_cast<size_t>(change.meshVertex[v])].Q() =
          static_cast<Scalarm>(change.ofVertices[static_cast<Eigen::Index>(v)]);
    changed |= MeshModel::MM_VERTQUALITY;
    if (change.ofFaces) {
      Eigen::Index row =
          0;  // a surface's faces are the mesh's that are not deleted, in their order
      for (CFaceO& face : mesh.cm.face)
        if (!face.IsD()) face.Q() = static_cast<Scalarm>((*change.ofFaces)[row++]);
      changed |= MeshModel::MM_FACEQUALITY;
    }
    mesh.setMeshModified();
  }
  for (size_t i = 0; i < layers_.size(); ++i) {
    MeshModel& mesh = preparation.written(i);
    setMatrix(mesh.cm, layers_[i].matrix);
    mesh.setMeshModified();
    if (i == 0 && (firstBecomesCurrent_ || document_.mm() == nullptr))
      document_.setCurrentMesh(mesh.id());
    if (layers_[i].replacedId >= 0) changed |= wholeMesh | MeshModel::MM_VERTCOLOR;
    if (mesh.cm.sfn > 0 || mesh.cm.svn > 0)
      changed |= MeshModel::MM_FACEFLAGSELECT | MeshModel::MM_VERTFLAGSELECT;
  }
  if (current_ >= 0) document_.setCurrentMesh(current_);
  const int current = document_.mm() != nullptr ? document_.mm()->id() : -1;
  for (const int id : removedIds_) host::removeLayer(document_, id);
  // MeshLab makes the layer behind one that goes the current one, whichever was.
  if (!removedIds_.empty() && Layers(document_).find(current)) document_.setCurrentMesh(current);
  return changed;
}

}  // namespace sphere_propagation::host
