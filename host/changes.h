// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What a filter wants to write. Collected while it computes, and written in one go: a filter that
/// throws leaves the document exactly as it was.
///
/// Writing takes memory. All of what takes some comes first (attributes, texture coordinates, new
/// layers, the new content of old ones) and is taken back where it runs out; what is written then
/// cannot fail. Beyond our reach is what MeshLab allocates itself, its windows when layers come and
/// go and its copy of what a filter returns; and in 2020.09, where a mesh can only be copied, the
/// content of a layer that was to be replaced is lost where memory does not suffice to put it back.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/layers.h"
#include "host/message.h"

class MeshDocument;
class CMeshO;

namespace sphere_propagation::host {

/// A layer to be made.
struct NewLayer {
  std::string label;
  LayerKind kind = LayerKind::Surface;
  Points vertices;
  Triangles faces;
  std::optional<Colors> colors;                             ///< per vertex
  std::optional<Eigen::VectorXd> quality;                   ///< per vertex
  std::map<std::string, Points> pointAttributes;            ///< per vertex
  std::map<std::string, int> marks;                         ///< see layers.h
  std::map<std::string, Eigen::VectorXd> scalarAttributes;  ///< per vertex
  std::vector<char> selectedVertices, selectedFaces;        ///< empty: none
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  std::optional<Vector3> aside;  ///< by how much it is shown beside its place (asideAttribute)
  std::optional<int>
      replacedId;  ///< the layer that it takes the place of; default: see Changes::addLayer
};

/// What takes the place of a layer's mesh.
struct RemadeMesh {
  Points vertices;          ///< #V by 3, the layer's matrix applied
  Triangles faces;          ///< #F by 3
  std::vector<int> source;  ///< #V: the vertex of the former mesh in whose place each is; -1: none
  std::map<std::string, Eigen::VectorXd> scalarAttributes;  ///< per vertex
  std::vector<char> selectedVertices, selectedFaces;        ///< empty: none
};

class Changes {
 public:
  explicit Changes(MeshDocument& document);
  ~Changes();
  Changes(const Changes&) = delete;
  Changes& operator=(const Changes&) = delete;

  /// Stores a map on a layer, as attribute and as texture coordinates, each certified as it is
  /// stored. root: the mark of the root that it came from; nothing where the layer is a root
  /// itself: it gets a mark of its own. Returns what the user should know about that; usually
  /// nothing: texture coordinates are floats, in some hosts the attribute is as well, and where
  /// rounding makes faces flip beyond mending, one of them alone is kept. Throws Refusal when
  /// neither holds the map.
  std::optional<Remark> setMap(const Layer& layer, const MeshSurface& surface,
                               const MappedSurface& map, std::optional<int> root = {});

  /// The mark of the root that the map set last on a layer came from; nothing where none is set.
  std::optional<int> rootOfMapOn(const Layer& layer) const;

  /// Puts a mark on a layer, see layers.h.
  void setMark(const Layer& layer, const char* name, int value);

  /// Puts anchors on a layer in place of those that it has. anchors: the layer's matrix, as it is
  /// in place, applied.
  void setAnchors(const Layer& layer, const AnchorSet& anchors);

  /// Reflects what a layer shows across the plane x = plane, and turns its faces so that they look
  /// outward as before, with what belongs to their corners; normals are made anew. The matrix
  /// stays, unless it flattens the layer: then it becomes the identity. A map that is set is that
  /// of the mirrored surface.
  void mirror(const Layer& layer, double plane);

  /// Colours the vertices of a layer. colors: one per vertex of `surface`, which the layer was read
  /// as.
  void setColors(const Layer& layer, const MeshSurface& surface, Colors colors);

  /// Stores numbers as MeshLab's quality, which its colour ramps, histograms and selections work
  /// on. ofVertices, ofFaces: one per vertex and one per face of `surface`; without the second,
  /// faces keep what they have.
  void setQuality(const Layer& layer, const MeshSurface& surface, Eigen::VectorXd ofVertices,
                  std::optional<Eigen::VectorXd> ofFaces = {});

  /// Adds a layer at the end of the list; or, where the document has a layer of this label and
  /// kind, which an earlier run made, replaces what that one holds. A file name's ending behind
  /// that label is overlooked, but not in layers of a model: one that was loaded is there to be
  /// compared with. Returns whether it takes the place of another one.
  bool addLayer(const NewLayer& layer);

  /// Puts another mesh into a layer, in the place of `former`, which the layer was read as. Matrix,
  /// label and visibility stay, and so do coordinates as they are stored, colours and quality of
  /// vertices that were there; new ones are grey. All else that the layer carried is gone.
  void remakeMesh(const Layer& layer, const MeshContent& former, RemadeMesh mesh);

  /// Shows a layer elsewhere than it is now, by its matrix alone; what is read of it stays what it
  /// is in its place.
  void showAside(const Layer& layer, const Vector3& move);

  /// Shows a layer in its place again.
  void showInPlace(const Layer& layer);

  /// Removes a layer.
  void removeLayer(const Layer& layer) { removedIds_.push_back(layer.id()); }

  /// Removes the layers of this kind that an earlier run made and this one does not replace. Called
  /// after the last addLayer. What was loaded from a file, by its name, stays.
  void removeOtherLayers(LayerKind kind);

  /// Makes the first of the new layers the current one (else the current layer stays).
  void makeFirstNewLayerCurrent() { firstBecomesCurrent_ = true; }
  /// Makes a layer that there is the current one.
  void makeCurrent(const Layer& layer) { current_ = layer.id(); }

  /// Whether layers are made or moved, so that the view is to be set anew.
  bool movesLayers() const { return !layers_.empty() || !places_.empty(); }

  /// Writes everything. Called once, by the plugin, after the filter has returned. Returns what was
  /// changed on layers, as a mask of the host's. Throws std::bad_alloc, with the document as it
  /// was, when memory runs out.
  int commit();

 private:
  class Preparation;
  struct MapChange;
  struct MirrorChange;
  struct ColorChange;
  struct QualityChange;
  struct MarkChange;
  struct AnchorChange;
  struct PlaceChange;
  struct LayerChange;
  MeshDocument& document_;
  std::vector<MapChange> maps_;
  std::vector<MirrorChange> mirrors_;
  std::vector<ColorChange> colors_;
  std::vector<QualityChange> qualities_;
  std::vector<MarkChange> marks_;
  std::vector<AnchorChange> anchors_;
  std::vector<PlaceChange> places_;
  std::vector<LayerChange> layers_;
  std::vector<int> removedIds_;
  bool firstBecomesCurrent_ = false;
  int current_ = -1;  // the id of the layer that is to be it
};

}  // namespace sphere_propagation::host
