// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The layers of a document as the filters see them: what kind each is, its surface, and the map
/// that it carries.

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "vcg_ext/anchors/anchor_set.h"
#include "vcg_ext/display/colors.h"
#include "vcg_ext/mesh/vcg_conversion.h"
#include "vcg_ext/sphere/mapped_surface.h"

class MeshDocument;
class MeshModel;

namespace sphere_propagation::host {

/// Where the map lives on a mesh: a point attribute per vertex, and the texture coordinates (which
/// files keep).
constexpr const char* spherePositionAttribute = "sphere_position";

/// Marks: numbers that a layer carries from one filter to the next, 1 to 2^24 - 1. A mark is a
/// scalar attribute with one value for all vertices: it goes where the map's attribute goes, also
/// where MeshLab copies a mesh, which loses what is stored once per mesh; and it is gone where that
/// one is gone, as in files and in layers that MeshLab's filter duplicates.
///
/// Which root a map came from: the fingerprint of the root's own map, on the root and on all layers
/// that its map was handed to; on landmark layers that of the map that they were sampled from.
constexpr const char* rootMark = "sphere_root";
/// On landmark layers: the fingerprint of the map that they were sampled from.
constexpr const char* sampledMapMark = "sphere_map";

/// On what the fit of a shape model made: 1. It is no landmark layer, as it is what a model
/// expects, not what was measured.
constexpr const char* fitMark = "model_fit";

/// Which vertices are on lids, that is, made up: a scalar attribute with the number of the opening
/// that the lid closes (from 1), 0 elsewhere. On prepared surfaces, and on landmarks of these.
constexpr const char* lidAttribute = "lid";

/// Layers that are shown beside their place carry, as point attributes with one value for all
/// vertices, the translation of their matrix in place and the one that shows them aside. Where the
/// matrix was changed since, the difference counts.
constexpr const char* inPlaceAttribute = "shown_in_place";
constexpr const char* asideAttribute = "shown_aside";

/// Anchors, the user's own landmarks, as point attributes of one value for all vertices, which go
/// where the map goes: this and the anchor's name, of which each byte that is not a letter of
/// ASCII, a digit, '-' or '_' is written %20. The value is a place in the frame of the vertices as
/// they are stored.
constexpr const char* anchorAttributePrefix = "anchor_";
std::string anchorAttribute(const std::string& anchor);

/// What a layer is, told from what it holds, so that nothing need be hidden by hand and files
/// loaded again are known.
enum class LayerKind {
  Surface,    ///< anything else: what maps are made for
  Landmarks,  ///< its face list is the icosphere's of its size
  Sphere,     ///< its vertices all lie on the unit sphere
  Model,      ///< made by the shape model: "mean shape", "mode 1 -3 sd"
  Anchors,    ///< spheres that show anchors: "heart anchors"
  Fit,        ///< a model fitted to a surface (fitMark)
  Morph,      ///< between two surfaces: "diastole to systole 25 %"
};

/// The relative precision of the coordinates that the host's meshes hold.
double coordinateEpsilon();

/// A layer, to be read.
class Layer {
 public:
  explicit Layer(const MeshModel& mesh) : mesh_(&mesh) {}

  int id() const;
  std::string label() const;
  /// The label without a file name's ending, and " suffix" behind it: what a layer made from this
  /// one is called.
  std::string derivedLabel(const std::string& suffix) const;
  /// The label without what MeshLab appends to the second layer of a name, "(1)", and without a
  /// file name's ending.
  std::string plainLabel() const;
  /// Whether the label ends as a file's name does.
  bool hasFileName() const;
  bool visible() const;
  /// Whether its file is still being read: MeshLab's window lets a filter be chosen meanwhile, and
  /// faces have no vertices then, so that nothing else may be asked.
  bool isBeingRead() const;
  LayerKind kind() const;

  int vertexCount() const;
  /// Whether it is shown beside its place, see asideAttribute.
  bool isShownAside() const;
  /// The layer's matrix, as it is when the layer is in its place.
  Eigen::Matrix4d matrix() const;
  /// The box of its vertices where it is shown; empty where it has none that are finite.
  Eigen::AlignedBox3d shownBox() const;
  /// The layer's geometry: its matrix, as it is in place, times its vertices. Throws SurfaceError,
  /// which names the layer.
  MeshSurface surface() const;
  /// What the layer holds, its matrix applied, whatever is wrong with it.
  MeshContent content() const;
  /// The map that the layer carries: the attribute, else the texture coordinates, whichever
  /// certifies as a map of this surface; ordinary texture coordinates do not, and are no map.
  std::optional<MappedSurface> map(const MeshSurface& surface) const;
  /// The positions stored on the layer, certified or not (#V by 3, in the surface's numbering): the
  /// attribute where there is one, else the texture coordinates; empty when it has neither. For
  /// measurements.
  std::optional<Points> storedPositions(const MeshSurface& surface) const;
  /// Whether it has the attribute of a map, valid or not.
  bool hasAttribute() const;
  /// Whether its matrix shows its mirror image; faces that are read are turned over then.
  bool mirrors() const;
  /// The number of the lid of each vertex, 0 where it is on none; empty: the layer has no lids.
  /// meshVertex: as MeshSurface or MeshContent has it.
  std::vector<int> lids(const std::vector<int>& meshVertex) const;
  /// Its anchors, its matrix applied as it is in place; those without a finite place are left out.
  AnchorSet anchors() const;
  /// The file that it was loaded from, with its folder; empty where there is none.
  std::string fileName() const;
  /// The number of a mark; nothing where the layer has none, or more than one.
  std::optional<int> mark(const char* name) const;
  /// Stands for what is stored as the layer's map, valid or not, and for its faces; nothing where
  /// nothing is stored.
  std::optional<int> mapFingerprint() const;
  /// Whether anything is stored where a map would be: the attribute, or texture coordinates of any
  /// kind.
  bool storesPositions() const;
  /// Whether it carries a map; quick, and false where the layer is not a closed surface.
  bool hasMap() const;
  /// The vertices as they are stored, without the layer's matrix (#V by 3, in the surface's
  /// numbering): those of a sphere layer lie on the unit sphere wherever it is shown.
  Points storedVertices(const MeshSurface& surface) const;
  /// The frequency of the icosphere whose face list the layer has: landmark layers, and what the
  /// shape model made.
  std::optional<int> icosphereFrequency() const;
  /// What the faces enclose with the centre of the box, whatever is wrong with them: the volume
  /// where the layer is closed. Quick, and finite; 0 where no volume can be told.
  double enclosedVolume() const;
  /// Red, green, blue of each vertex of the surface, if the layer has colours of its own.
  std::optional<Colors> colors(const MeshSurface& surface) const;

 private:
  std::optional<Points> attributePositions(const MeshSurface& surface) const;
  std::optional<Points> texturePositions(const MeshSurface& surface) const;

  const MeshModel* mesh_;
};

/// The document, to be read. Layers whose file is still being read are not there yet.
class Layers {
 public:
  explicit Layers(const MeshDocument& document) : document_(document) {}

  /// Throws Refusal where a layer is still being read.
  void requireRead() const;

  /// The current layer. Throws Refusal when there is none.
  Layer current() const;
  /// The id of the current layer, -1 when there is none.
  int currentId() const;
  /// The layer with this id, if there is one.
  std::optional<Layer> find(int id) const;
  /// All layers of a kind, visible or not, in layer order.
  std::vector<Layer> all(LayerKind kind) const;
  /// The visible layers of a kind, in layer order.
  std::vector<Layer> visible(LayerKind kind) const;
  /// The same; throws Refusal, which says what to do, when there is none.
  std::vector<Layer> visibleSurfaces() const;

 private:
  const MeshDocument& document_;
};

}  // namespace sphere_propagation::host
