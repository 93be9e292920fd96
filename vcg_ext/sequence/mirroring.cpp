// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/mirroring.h"

#include <algorithm>
#include <utility>

#include "vcg_ext/registration/shape_alignment.h"

namespace sphere_propagation {
namespace {

// Of layers that are not mirrored the mirror image fits at most this much better (or, below 1,
// worse): 0.84 between neighbours of two hearts' cycles, 0.99 between end-diastole and any other
// phase, 1.05 among skulls of twelve species.
constexpr double clearlyBetter = 1.15;
constexpr double hardlyDifferent = 0.02;  // in R, the radius of the sphere of the parent's area
// In the smaller R: farther off, the image is no better known than the layer, as where the parent
// is another organ.
constexpr double recognisable = 0.25;

}  // namespace

ClosedSurface mirrorImage(const ClosedSurface& surface, double plane) {
  Points vertices = surface.vertices();
  vertices.col(0) = (2 * plane - vertices.col(0).array()).matrix();
  Triangles faces = surface.faces();
  faces.col(1).swap(faces.col(2));
  return {std::move(vertices), std::move(faces), surface.name()};
}

std::vector<std::optional<double>> findMirrorPlanes(const std::vector<ClosedSurface>& surfaces,
                                                    const PropagationTree& tree, ThreadPool& pool) {
  std::vector<AlignedShape> shapes = alignedShapes(surfaces, pool);
  std::vector<std::optional<double>> planes(surfaces.size());
  const auto look = [&](int layer) {
    const auto i = static_cast<size_t>(layer);
    const AlignedShape& parent = shapes[static_cast<size_t>(tree.parent[i])];  // as it will be
    const double asItLies = shapeDistance(shapes[i], parent);
    if (asItLies < hardlyDifferent * parent.radius()) return;
    const double itself =
        std::min(asItLies, shapeDistance(shapes[i], parent, motionFromAnywhere(shapes[i], parent)));
    const double plane = shapes[i].centre()[0];
    AlignedShape image(mirrorImage(surfaces[i], plane));
    const double mirrored = shapeDistance(image, parent, motionFromAnywhere(image, parent));
    if (!(itself > clearlyBetter * mirrored)) return;
    if (mirrored > recognisable * std::min(image.radius(), parent.radius())) return;
    planes[i] = plane;
    shapes[i] = std::move(image);
  };
  const std::vector<std::vector<int>> levels = tree.levels();
  for (size_t level = 1; level < levels.size(); ++level)
    pool.forEach(static_cast<int>(levels[level].size()),
                 [&](int k) { look(levels[level][static_cast<size_t>(k)]); });
  return planes;
}

}  // namespace sphere_propagation
