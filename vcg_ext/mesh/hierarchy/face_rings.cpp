// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/hierarchy/face_rings.h"

namespace sphere_propagation {

FaceRings FaceRings::of(const ClosedSurface& surface) {
  FaceRings rings;
  rings.faces = surface.faces();
  rings.offset.reserve(static_cast<size_t>(surface.vertexCount()) + 1);
  rings.corner.reserve(3 * static_cast<size_t>(surface.faceCount()));
  rings.offset.push_back(0);
  for (int v = 0; v < surface.vertexCount(); ++v) {
    for (int h : surface.outgoing(v)) rings.corner.push_back(h);
    rings.offset.push_back(static_cast<int>(rings.corner.size()));
  }
  return rings;
}

}  // namespace sphere_propagation
