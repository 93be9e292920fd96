#pragma once
/// What a filter wants to write. Collected while it computes, written in one go when nothing can fail any more: a
/// filter that throws leaves the document exactly as it was.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/layers.h"

class MeshDocument;
class CMeshO;

namespace sphere_propagation::host {

/// A layer to be made. Its matrix is the identity.
struct NewLayer {
  std::string label;
  LayerKind kind = LayerKind::Surface;
  Points vertices;
  Triangles faces;
  std::optional<Colors> colors;                   ///< per vertex
  std::map<std::string, Points> pointAttributes;  ///< per vertex
};

class Changes {
 public:
  explicit Changes(MeshDocument& document);
  ~Changes();
  Changes(const Changes&) = delete;
  Changes& operator=(const Changes&) = delete;

  /// Stores a map on a layer, as attribute and as texture coordinates. Returns what the user should know about that;
  /// usually nothing: texture coordinates are floats, and where rounding to them makes faces flip beyond mending, the
  /// attribute alone is kept.
  std::string setMap(const Layer& layer, const MeshSurface& surface, const SphereMap& map);

  /// Adds a layer at the end of the list; or, where the document has a layer of this label and kind, which an earlier
  /// run made, replaces what that one holds.
  void addLayer(const NewLayer& layer);

  /// Makes the first of the new layers the current one (else the current layer stays).
  void makeFirstNewLayerCurrent() { firstBecomesCurrent_ = true; }

  /// Writes everything. Called once, by the plugin, after the filter has returned.
  void commit();

 private:
  struct MapChange;
  struct LayerChange;
  MeshDocument& document_;
  std::vector<MapChange> maps_;
  std::vector<LayerChange> layers_;
  bool firstBecomesCurrent_ = false;
};

}  // namespace sphere_propagation::host
