// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/mirroring.h"

#include <algorithm>
#include <utility>

#include "vcg_ext/registration/prepared_surface.h"
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

std::vector<std::optional<double>> findMirrorPlanes(const Sequence& sequence,
                                                    const PropagationTree& tree, ThreadPool& pool) {
  sequence.prepare(pool);
  std::vector<PreparedSurface> shapes;  // as they will be
  for (int i = 0; i < sequence.size(); ++i) shapes.push_back(sequence[i]);
  std::vector<std::optional<double>> planes(shapes.size());
  const auto look = [&](int layer) {
    const auto i = static_cast<size_t>(layer);
    const PreparedSurface& parent = shapes[static_cast<size_t>(tree.parent[i])];
    const double asItLies = shapeDistance(shapes[i], parent);
    if (asItLies < hardlyDifferent * parent.radius()) return;
    const double itself =
        std::min(asItLies, shapeDistance(shapes[i], parent, motionFromAnywhere(shapes[i], parent)));
    const double plane = shapes[i].centre()[0];
    PreparedSurface image(mirrorImage(shapes[i].surface(), plane));
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

ReflectedSequence reflectMirrorImages(const Sequence& sequence, const PropagationOrder& order,
                                      int root, ThreadPool& pool) {
  ReflectedSequence result{sequence, {}, makeTree(order, sequence, root, pool)};
  result.planes.resize(static_cast<size_t>(sequence.size()));
  for (bool found = true; found;) {
    found = false;
    const std::vector<std::optional<double>> planes =
        findMirrorPlanes(result.sequence, result.tree, pool);
    for (int i = 0; i < sequence.size(); ++i) {
      const auto k = static_cast<size_t>(i);
      if (!planes[k] || result.planes[k]) continue;
      result.planes[k] = planes[k];
      result.sequence = result.sequence.with(i, mirrorImage(sequence.surface(i), *planes[k]));
      found = order.goesByShape();
    }
    if (found) result.tree = makeTree(order, result.sequence, root, pool);
  }
  return result;
}

}  // namespace sphere_propagation
