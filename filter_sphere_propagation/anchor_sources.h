// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Where the anchors of a layer come from: a file that is given, what the layer carries, or a file
/// beside the one that it was loaded from.

#include <string>
#include <vector>

#include "host/filter.h"
#include "vcg_ext/anchors/anchor_set.h"

namespace sphere_propagation {

/// An anchor farther off its surface than so many mean edge lengths is named.
constexpr double maxAnchorEdges = 5;

/// A mark (host/layers.h) of layers whose maps hold anchors exactly: 1, and 2 where they no longer
/// do.
constexpr const char* anchorsHeldMark = "anchors_held";
constexpr int anchorsHeld = 1, anchorsNotHeld = 2;
inline bool holdsAnchors(const host::Layer& layer) {
  return layer.mark(anchorsHeldMark) == anchorsHeld;
}

/// The frame of a file's places.
enum class AnchorFrame {
  World,  ///< where the layer is shown, its matrix applied, as MeshLab's Pick Points saves them
  Mesh,   ///< that of the vertices as the mesh's file has them
};

/// Reads the anchors of layers, and says what deserves to be known of their files.
class AnchorSources {
 public:
  AnchorSources(const host::Task& task, AnchorFrame frame) : task_(task), frame_(frame) {}

  /// The file of a folder that is called as the layer's file or as the layer; empty where there is
  /// none. Names the others where there are several.
  std::string fileIn(const std::string& folder, const host::Layer& layer) const;

  /// The anchors of a layer, its matrix applied. Places in LPS that lie on the layer as they are
  /// written, and not in RAS, are taken as they are written. Throws AnchorError.
  AnchorSet from(const std::string& file, const host::Layer& layer) {
    return read(file, layer, true);
  }

  /// The same for a file beside the layer's own, which nobody asked for: empty where there is none,
  /// where it is not a file of anchors, or where most of them lie far off the layer.
  AnchorSet beside(const host::Layer& layer);

  /// Says, when all are read, of which layers the places were taken as they are written.
  void sayWhichAsWritten() const;

 private:
  AnchorSet read(const std::string& file, const host::Layer& layer, bool isAsked);
  void compare(const host::Layer& layer, const std::string& taken, const AnchorSet& anchors,
               const std::string& other) const;

  const host::Task& task_;
  AnchorFrame frame_;
  std::vector<std::string> asWritten_;  ///< layers
};

bool isFolder(const std::string& path);

/// Names the anchors that lie far off their layer, and those that lie in one place.
void warnOfFarAnchors(const host::Task& task, const host::Layer& layer, const AnchorSet& anchors);

}  // namespace sphere_propagation
