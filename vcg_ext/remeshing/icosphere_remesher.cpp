// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/remeshing/icosphere_remesher.h"

#include <algorithm>

#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/sphere/sphere_walk.h"

namespace sphere_propagation {
IcosphereRemesher::IcosphereRemesher(int frequency)
    : sphere_(icosphere(frequency)),
      connected_(ClosedSurface(sphere_.vertices, sphere_.faces, "icosphere"), sphere_.vertices),
      order_(SurfaceLocator(sphere_.vertices, sphere_.faces).order()),
      rank_(order_.size()) {
  for (size_t i = 0; i < order_.size(); ++i)
    rank_[static_cast<size_t>(order_[i])] = static_cast<int>(i);
}

Remeshed IcosphereRemesher::remesh(const MappedSurface& surface) const {
  return sphere_propagation::remesh(surface, sphere_.vertices);
}

SurfaceDistance IcosphereRemesher::distance(const Remeshed& remeshed,
                                            const MappedSurface& mapped) const {
  const ClosedSurface& surface = mapped.surface();
  DistanceHints hints;
  hints.landmarksOnSurface = true;
  hints.landmarkFaces = order_;
  hints.nearVertex = facesUnder(mapped, [&](const Vector3& position, int start) {
    return walkOverSphere(connected_, position, start);
  });

  // The surface's faces in the order of the icosphere's faces under their first corners: a counting
  // sort.
  const auto rankOf = [&](int f) {
    return static_cast<size_t>(
        rank_[static_cast<size_t>(hints.nearVertex[static_cast<size_t>(surface.faces()(f, 0))])]);
  };
  std::vector<int> begin(order_.size() + 1, 0);
  for (int f = 0; f < surface.faceCount(); ++f) ++begin[rankOf(f) + 1];
  for (size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
  std::vector<int> next(begin.begin(), begin.end() - 1);
  hints.surfaceFaces.resize(static_cast<size_t>(surface.faceCount()));
  for (int f = 0; f < surface.faceCount(); ++f)
    hints.surfaceFaces[static_cast<size_t>(next[rankOf(f)]++)] = f;

  hints.nearCentroid.resize(order_.size());
  for (size_t i = 0; i < order_.size(); ++i) {
    const auto face = static_cast<size_t>(order_[i]);
    const int middle = begin[i] + (begin[i + 1] - begin[i]) / 2;
    hints.nearCentroid[face] =
        begin[i] < begin[i + 1]
            ? hints.surfaceFaces[static_cast<size_t>(middle)]
            : remeshed
                  .faces[static_cast<size_t>(sphere_.faces(static_cast<Eigen::Index>(face), 0))];
  }
  return surfaceDistance(remeshed.landmarks, sphere_.faces, surface, hints);
}

}  // namespace sphere_propagation
