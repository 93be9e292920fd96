// SPDX-License-Identifier: GPL-3.0-only
#include "host/layers.h"

#include <QByteArray>
#include <QFileInfo>
#include <QRegularExpression>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "host/document.h"
#include "host/messages.h"
#include "vcg_ext/base/fingerprint.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/mesh/usable_extent.h"
#include "vcg_ext/sphere/certificate.h"
#include "vcg_ext/sphere/sphere_coordinates.h"

namespace sphere_propagation::host {
namespace {

/// Faces of a mesh without deleted elements; empty when there are deleted ones, which no layer of
/// ours has.
Triangles compactFaces(const CMeshO& mesh) {
  if (static_cast<size_t>(mesh.fn) != mesh.face.size() ||
      static_cast<size_t>(mesh.vn) != mesh.vert.size())
    return {};
  Triangles faces(mesh.fn, 3);
  for (int f = 0; f < mesh.fn; ++f)
    for (int k = 0; k < 3; ++k)
      faces(f, k) = static_cast<int>(mesh.face[f].cV(k) - mesh.vert.data());
  return faces;
}

std::optional<int> frequencyOf(const CMeshO& mesh) {
  // Counts first: 10 f^2 + 2 vertices, 20 f^2 faces.
  if (mesh.vn < 12 || mesh.fn != 2 * mesh.vn - 4 || (mesh.vn - 2) % 10 != 0) return std::nullopt;
  return icosphereFrequency(mesh.vn, compactFaces(mesh));
}

bool isUnitSphere(const CMeshO& mesh) {
  if (mesh.fn == 0) return false;
  for (const CVertexO& v : mesh.vert)
    if (!v.IsD() && !(std::fabs(v.cP().Norm() - 1) <= Certificate::unitTolerance)) return false;
  return true;
}

QString withoutFileEnding(QString label) {
  static const QRegularExpression ending("\\.(ply|obj|stl|off|wrl|x3d|vtk|gltf|glb|dae|3ds|ctm)$",
                                         QRegularExpression::CaseInsensitiveOption);
  return label.remove(ending);
}

bool isModelName(const QString& label) {
  static const QRegularExpression pattern("^(mean shape|mode \\d+ [+-]\\S+ sd)( ?\\(\\d+\\))?$");
  return pattern.match(withoutFileEnding(label)).hasMatch();
}

bool isAnchorsName(const QString& label) {
  static const QRegularExpression pattern("\\S anchors( ?\\(\\d+\\))?$");
  return pattern.match(withoutFileEnding(label)).hasMatch();
}

bool isMorphName(const QString& label) {
  static const QRegularExpression pattern("\\S to \\S.* \\d+(\\.\\d+)? %( ?\\(\\d+\\))?$");
  return pattern.match(withoutFileEnding(label)).hasMatch();
}

}  // namespace

namespace {

bool standsForItself(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '_';
}

/// The name of the anchor that an attribute holds; nothing where it holds none.
std::optional<std::string> anchorOfAttribute(const std::string& attribute) {
  const std::string prefix = anchorAttributePrefix;
  if (attribute.size() <= prefix.size() || attribute.rfind(prefix, 0) != 0) return std::nullopt;
  return QByteArray::fromPercentEncoding(QByteArray::fromStdString(attribute.substr(prefix.size())))
      .toStdString();
}

/// A point attribute of one value for all vertices.
std::optional<Vector3> firstOf(const MeshModel& mesh, const char* name) {
  const auto points = pointAttribute(mesh.cm, name);
  if (!points || points->rows() == 0) return std::nullopt;
  return Vector3(points->row(0).transpose());
}

}  // namespace

std::string anchorAttribute(const std::string& anchor) {
  constexpr const char* digits = "0123456789ABCDEF";
  std::string attribute = anchorAttributePrefix;
  for (const char c : anchor) {
    if (standsForItself(c)) {
      attribute += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    attribute += '%';
    attribute += digits[byte / 16];
    attribute += digits[byte % 16];
  }
  return attribute;
}

double coordinateEpsilon() { return static_cast<double>(std::numeric_limits<Scalarm>::epsilon()); }

int Layer::id() const { return mesh_->id(); }
std::string Layer::label() const { return mesh_->label().toStdString(); }
std::string Layer::derivedLabel(const std::string& suffix) const {
  return withoutFileEnding(mesh_->label()).toStdString() + " " + suffix;
}
std::string Layer::plainLabel() const {
  static const QRegularExpression number("\\(\\d+\\)$");
  return withoutFileEnding(QString(mesh_->label()).remove(number)).toStdString();
}
bool Layer::hasFileName() const { return withoutFileEnding(mesh_->label()) != mesh_->label(); }
bool Layer::visible() const { return mesh_->isVisible(); }

LayerKind Layer::kind() const {
  if (isModelName(mesh_->label())) return LayerKind::Model;
  if (isAnchorsName(mesh_->label())) return LayerKind::Anchors;
  if (isMorphName(mesh_->label())) return LayerKind::Morph;
  if (mark(fitMark)) return LayerKind::Fit;
  if (isUnitSphere(mesh_->cm)) return LayerKind::Sphere;
  if (frequencyOf(mesh_->cm)) return LayerKind::Landmarks;
  return LayerKind::Surface;
}

bool Layer::isBeingRead() const {
  return std::any_of(mesh_->cm.face.begin(), mesh_->cm.face.end(), [](const CFaceO& f) {
    return !f.IsD() && (f.cV(0) == nullptr || f.cV(1) == nullptr || f.cV(2) == nullptr);
  });
}

int Layer::vertexCount() const { return mesh_->cm.vn; }

bool Layer::isShownAside() const { return firstOf(*mesh_, asideAttribute).has_value(); }

Eigen::Matrix4d Layer::matrix() const {
  Eigen::Matrix4d matrix = matrixFromVcg(mesh_->cm.Tr);
  const auto inPlace = firstOf(*mesh_, inPlaceAttribute), aside = firstOf(*mesh_, asideAttribute);
  if (!inPlace || !aside) return matrix;
  auto shown = matrix.topRightCorner<3, 1>();
  if (shown == *aside)
    shown = *inPlace;
  else
    shown -= *aside - *inPlace;
  return matrix;
}

Eigen::AlignedBox3d Layer::shownBox() const {
  const Eigen::Matrix4d matrix = matrixFromVcg(mesh_->cm.Tr);
  Eigen::AlignedBox3d box;
  for (const CVertexO& v : mesh_->cm.vert) {
    if (v.IsD()) continue;
    const Vector3 p =
        (matrix * Eigen::Vector4d(v.cP()[0], v.cP()[1], v.cP()[2], 1)).template head<3>();
    if (p.allFinite()) box.extend(p);
  }
  return box;
}

MeshSurface Layer::surface() const {
  MeshSurface mesh = surfaceFromMesh(mesh_->cm, matrix(), label());
  requireUsableExtent(mesh.surface);
  return mesh;
}

MeshContent Layer::content() const { return contentOfMesh(mesh_->cm, matrix()); }

std::optional<Points> Layer::attributePositions(const MeshSurface& surface) const {
  const auto stored = pointAttribute(mesh_->cm, spherePositionAttribute);
  if (!stored) return std::nullopt;
  Points positions(surface.surface.vertexCount(), 3);
  for (size_t v = 0; v < surface.meshVertex.size(); ++v)
    positions.row(static_cast<Eigen::Index>(v)) = stored->row(surface.meshVertex[v]);
  return positions;
}

std::optional<Points> Layer::texturePositions(const MeshSurface& surface) const {
  if (!mesh_->hasDataMask(MeshModel::MM_VERTTEXCOORD)) return std::nullopt;
  Points positions(surface.surface.vertexCount(), 3);
  for (size_t v = 0; v < surface.meshVertex.size(); ++v) {
    const auto& t = mesh_->cm.vert[static_cast<size_t>(surface.meshVertex[v])].cT();
    positions.row(static_cast<Eigen::Index>(v)) =
        spherePosition({static_cast<double>(t.U()), static_cast<double>(t.V())}).transpose();
  }
  return positions;
}

std::optional<Points> Layer::storedPositions(const MeshSurface& surface) const {
  if (auto positions = attributePositions(surface)) return positions;
  return texturePositions(surface);
}

std::optional<MappedSurface> Layer::map(const MeshSurface& surface) const {
  if (auto positions = attributePositions(surface))
    if (auto map = MappedSurface::ifValid(surface.surface, std::move(*positions))) return map;
  if (auto positions = texturePositions(surface))
    return MappedSurface::ifValid(surface.surface, std::move(*positions));
  return std::nullopt;
}

bool Layer::hasAttribute() const {
  return pointAttribute(mesh_->cm, spherePositionAttribute).has_value();
}

AnchorSet Layer::anchors() const {
  AnchorSet anchors;
  for (const std::string& attribute : pointAttributeNames(mesh_->cm)) {
    const std::optional<std::string> name = anchorOfAttribute(attribute);
    const std::optional<Vector3> place = name ? firstOf(*mesh_, attribute.c_str()) : std::nullopt;
    if (place && place->allFinite()) anchors.emplace(*name, *place);
  }
  return transformed(anchors, matrix());
}

std::string Layer::fileName() const {
  const QString name = mesh_->fullName();
  return name.isEmpty() ? "" : QFileInfo(name).absoluteFilePath().toStdString();
}

std::optional<int> Layer::mark(const char* name) const {
  const auto values = scalarAttribute(mesh_->cm, name);
  if (!values) return std::nullopt;
  std::optional<double> value;
  for (size_t v = 0; v < mesh_->cm.vert.size(); ++v) {
    if (mesh_->cm.vert[v].IsD()) continue;
    if (value && *value != (*values)[static_cast<Eigen::Index>(v)]) return std::nullopt;
    value = (*values)[static_cast<Eigen::Index>(v)];
  }
  constexpr double end = 1 << 24;
  if (!value || !(*value >= 1 && *value < end)) return std::nullopt;
  return static_cast<int>(*value);
}

bool Layer::mirrors() const {
  return matrixFromVcg(mesh_->cm.Tr).topLeftCorner<3, 3>().determinant() < 0;
}

std::vector<int> Layer::lids(const std::vector<int>& meshVertex) const {
  const auto values = scalarAttribute(mesh_->cm, lidAttribute);
  if (!values) return {};
  constexpr double most = 1 << 24;
  std::vector<int> lids;
  bool any = false;
  for (const int v : meshVertex) {
    const double value = (*values)[v];  // files and users write what they like
    lids.push_back(value > 0 ? static_cast<int>(std::ceil(std::min(value, most))) : 0);
    any = any || lids.back() > 0;
  }
  return any ? lids : std::vector<int>();
}

std::optional<int> Layer::mapFingerprint() const {
  if (!storesPositions()) return std::nullopt;
  const CMeshO& mesh = mesh_->cm;
  const auto positions = pointAttribute(mesh, spherePositionAttribute);
  Fingerprint fingerprint;
  std::vector<int> number(mesh.vert.size(), 0);  // without the deleted ones
  for (size_t v = 0, count = 0; v < mesh.vert.size(); ++v) {
    if (mesh.vert[v].IsD()) continue;
    number[v] = static_cast<int>(count++);
    if (positions) {
      for (int k = 0; k < 3; ++k) fingerprint.add((*positions)(static_cast<Eigen::Index>(v), k));
    } else {
      fingerprint.add(static_cast<double>(mesh.vert[v].cT().U()));
      fingerprint.add(static_cast<double>(mesh.vert[v].cT().V()));
    }
  }
  for (const CFaceO& face : mesh.face)
    if (!face.IsD())
      for (int k = 0; k < 3; ++k)
        fingerprint.add(number[static_cast<size_t>(face.cV(k) - mesh.vert.data())]);
  return fingerprint.short24();
}

bool Layer::storesPositions() const {
  return hasAttribute() || mesh_->hasDataMask(MeshModel::MM_VERTTEXCOORD);
}

bool Layer::hasMap() const {
  if (!storesPositions()) return false;
  try {
    return map(surface()).has_value();
  } catch (const Error&) {
    return false;
  }
}

Points Layer::storedVertices(const MeshSurface& surface) const {
  Points points(surface.surface.vertexCount(), 3);
  for (size_t v = 0; v < surface.meshVertex.size(); ++v) {
    const Point3m& p = mesh_->cm.vert[static_cast<size_t>(surface.meshVertex[v])].cP();
    points.row(static_cast<Eigen::Index>(v)) << p[0], p[1], p[2];
  }
  return points;
}

std::optional<int> Layer::icosphereFrequency() const { return frequencyOf(mesh_->cm); }

double Layer::enclosedVolume() const {
  // From the centre of the box: coordinates of a scanner may be far from the origin, and a hole
  // then costs little.
  const CMeshO& mesh = mesh_->cm;
  vcg::Box3<Scalarm> box;
  for (const CVertexO& v : mesh.vert)
    if (!v.IsD()) box.Add(v.cP());
  if (box.IsNull()) return 0;
  const auto at = [&](const CFaceO& f, int k) {
    const Point3m p = f.cV(k)->cP() - box.Center();
    return Vector3(p[0], p[1], p[2]);
  };
  double volume = 0;
  for (const CFaceO& f : mesh.face)
    if (!f.IsD()) volume += at(f, 0).dot(at(f, 1).cross(at(f, 2))) / 6;
  volume = std::fabs(volume * matrixFromVcg(mesh.Tr).topLeftCorner<3, 3>().determinant());
  return std::isfinite(volume) ? volume : 0;
}

std::optional<Colors> Layer::colors(const MeshSurface& surface) const {
  if (!mesh_->hasDataMask(MeshModel::MM_VERTCOLOR)) return std::nullopt;
  Colors colors(surface.surface.vertexCount(), 3);
  for (size_t v = 0; v < surface.meshVertex.size(); ++v) {
    const auto& c = mesh_->cm.vert[static_cast<size_t>(surface.meshVertex[v])].cC();
    colors.row(static_cast<Eigen::Index>(v)) << c[0], c[1], c[2];
  }
  return colors;
}

void Layers::requireRead() const {
  for (const MeshModel* mesh : meshesOf(document_))
    if (const Layer layer(*mesh); layer.isBeingRead())
      throw Refusal(messages::stillBeingRead, layer.label());
}

Layer Layers::current() const {
  if (document_.mm() == nullptr) throw Refusal(messages::noLayer);
  return Layer(*document_.mm());
}

int Layers::currentId() const { return document_.mm() != nullptr ? document_.mm()->id() : -1; }

std::optional<Layer> Layers::find(int id) const {
  if (id < 0) return std::nullopt;
  const MeshModel* mesh = document_.getMesh(static_cast<unsigned int>(id));
  if (mesh == nullptr || Layer(*mesh).isBeingRead()) return std::nullopt;
  return Layer(*mesh);
}

std::vector<Layer> Layers::all(LayerKind kind) const {
  std::vector<Layer> found;
  for (const MeshModel* mesh : meshesOf(document_))
    if (const Layer layer(*mesh); !layer.isBeingRead() && layer.kind() == kind)
      found.push_back(layer);
  return found;
}

std::vector<Layer> Layers::visible(LayerKind kind) const {
  std::vector<Layer> found;
  for (const MeshModel* mesh : meshesOf(document_)) {
    const Layer layer(*mesh);
    if (layer.visible() && !layer.isBeingRead() && layer.kind() == kind) found.push_back(layer);
  }
  return found;
}

std::vector<Layer> Layers::visibleSurfaces() const {
  std::vector<Layer> found = visible(LayerKind::Surface);
  if (found.empty()) throw Refusal(messages::noVisibleSurface);
  return found;
}

}  // namespace sphere_propagation::host
