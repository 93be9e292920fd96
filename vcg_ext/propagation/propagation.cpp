// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/propagation.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include "vcg_ext/area/area_restoration.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/base/stopwatch.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/propagation/aligned/aligned_propagation.h"
#include "vcg_ext/propagation/motion/motion_propagation.h"

namespace sphere_propagation {
namespace {

/// Of the time, where areas are restored: that takes several times as long as an arc.
constexpr double propagationShare = 0.2;
/// Of the time of method Robust, where no layer is lost.
constexpr double followingShare = 0.95;

void requireFit(const std::vector<ClosedSurface>& surfaces, const SphereMap& rootMap,
                const PropagationTree& tree, const PropagationParameters& parameters) {
  if (surfaces.empty() || tree.parent.size() != surfaces.size() ||
      tree.order.size() != surfaces.size())
    throw ParameterError("The order of propagation is one of " +
                         std::to_string(tree.parent.size()) + " layers, but there are " +
                         std::to_string(surfaces.size()) + ".");
  const ClosedSurface& root = surfaces[tree.root()];
  if (rootMap.positions().rows() != root.vertexCount())
    throw ParameterError("The root, layer \"" + root.name() + "\", has " +
                         std::to_string(root.vertexCount()) +
                         " vertices, but the map that is given as its has " +
                         std::to_string(rootMap.positions().rows()) + " positions.");
  if (!(parameters.areaRestoration >= 0 && parameters.areaRestoration <= 1))
    throw ParameterError("The area restoration must lie between 0 and 1; it is " +
                         std::to_string(parameters.areaRestoration) + ".");
  if (parameters.closing)
    for (int i : {parameters.closing->from, parameters.closing->to})
      if (i < 0 || i >= tree.size())
        throw ParameterError("The arc that closes the cycle joins layer " + std::to_string(i) +
                             ", which does not exist.");
  if (parameters.threads < 0)
    throw ParameterError("The number of threads must not be negative; it is " +
                         std::to_string(parameters.threads) + ".");
}

/// The size of each layer relative to its parent's; 1 at the root.
std::vector<double> relativeSizes(const std::vector<ClosedSurface>& surfaces,
                                  const PropagationTree& tree) {
  std::vector<double> sizes, relative(surfaces.size(), 1);
  for (const ClosedSurface& surface : surfaces)
    sizes.push_back(radiusOfSphere(faceAreas(surface.vertices(), surface.faces()).sum()));
  for (size_t i = 0; i < surfaces.size(); ++i)
    if (tree.parent[i] >= 0) relative[i] = sizes[i] / sizes[static_cast<size_t>(tree.parent[i])];
  return relative;
}

void requireOneUnit(const std::vector<ClosedSurface>& surfaces, const PropagationTree& tree,
                    const std::vector<double>& relativeSizes) {
  for (size_t i = 0; i < surfaces.size(); ++i) {
    const double ratio = relativeSizes[i];
    if (ratio < maxRelativeSize && ratio > 1 / maxRelativeSize) continue;
    std::ostringstream text;
    text.precision(3);
    text << "Layer \"" << surfaces[i].name() << "\" is " << (ratio > 1 ? ratio : 1 / ratio)
         << " times " << (ratio > 1 ? "larger" : "smaller") << " than layer \""
         << surfaces[static_cast<size_t>(tree.parent[i])].name()
         << "\", which its map would come from. Bring all layers to one unit (\"Transform: Scale, "
            "Normalize\").";
    throw ParameterError(text.str());
  }
}

PropagatedLayer propagateArc(const ClosedSurface& reference, const SphereMap& referenceMap,
                             const ClosedSurface& target, const PropagationParameters& parameters) {
  try {
    if (parameters.method == PropagationMethod::Robust) {
      try {
        RobustPropagation arc = propagateRobustly(reference, referenceMap, target);
        return {std::move(arc.map),
                -1,
                arc.repairedFaces,
                arc.residualMean,
                arc.residualP95,
                0,
                Route::Alignment,
                {},
                1,
                std::move(arc.distances)};
      } catch (const MapError&) {
        // Shapes that differ much: the published steps smooth all of the map, and so reach a valid
        // one more often.
      }
    }
    PublishedPropagation arc =
        propagateAsPublished(reference, referenceMap, target, parameters.published);
    const Route route =
        parameters.method == PropagationMethod::Robust ? Route::Published : Route::Method;
    return {std::move(arc.map),
            -1,
            arc.repairedFaces,
            arc.residualMean,
            arc.residualP95,
            0,
            route,
            {},
            1,
            std::move(arc.distances)};
  } catch (const MapError& error) {  // names the target, but knows nothing of the tree
    throw MapError(error.count, error.first,
                   std::string(error.what()) + " They come from layer \"" + reference.name() +
                       "\", which may be too different from it: choose another order of "
                       "propagation or another root.");
  }
}

/// Does something to every layer but the root, parents before their children; progress goes by
/// vertices.
void overArcs(const std::vector<ClosedSurface>& surfaces, const PropagationTree& tree,
              const Progress& progress,
              const std::function<void(int layer, const Progress& ofLayer)>& act) {
  double vertices = 0, done = 0;
  for (int i : tree.order)
    if (i != tree.root()) vertices += surfaces[i].vertexCount();
  for (int i : tree.order) {
    if (i == tree.root()) continue;
    const double before = done;
    done += surfaces[i].vertexCount();
    act(i, part(progress, before / vertices, done / vertices));
    report(progress, done / vertices);
  }
  report(progress, 1);
}

}  // namespace

Propagation propagate(const std::vector<ClosedSurface>& surfaces, const SphereMap& rootMap,
                      const PropagationTree& tree, const PropagationParameters& parameters,
                      const Progress& progress) {
  requireFit(surfaces, rootMap, tree, parameters);
  std::vector<std::optional<PropagatedLayer>> layers(surfaces.size());
  layers[tree.root()] =
      PropagatedLayer{rootMap,
                      -1,
                      0,
                      0,
                      0,
                      0,
                      Route::Method,
                      {},
                      1,
                      std::vector<double>(surfaces[tree.root()].vertexCount(), 0)};
  const bool restores = parameters.areaRestoration > 0;
  const Progress ofArcs = part(progress, 0, restores ? propagationShare : 1);
  // Robust: the root's motion, followed through all layers; arc by arc where that loses a layer.
  FollowedMotion followed;
  followed.layers.resize(surfaces.size());
  std::vector<LayerPose> poses(surfaces.size());
  std::vector<ClosedSurface> inRootsFrame;
  LayerLocators locators;
  const bool follows = parameters.method == PropagationMethod::Robust;
  const std::vector<double> sizes = relativeSizes(surfaces, tree);
  if (follows) requireOneUnit(surfaces, tree, sizes);
  report(progress, 0);
  ThreadPool pool(parameters.threads);
  if (follows) {
    const std::vector<AlignedShape> shapes = alignedShapes(surfaces, pool);
    poses = findLayerPoses(surfaces, shapes, tree, pool);
    if (std::any_of(poses.begin(), poses.end(), [](const LayerPose& pose) { return pose.moved; }))
      for (size_t i = 0; i < surfaces.size(); ++i)
        inRootsFrame.push_back(movedSurface(surfaces[i], poses[i].toRoot));
    else
      for (const AlignedShape& shape : shapes) locators.push_back(shape.locator());
  }
  const std::vector<ClosedSurface>& placed = inRootsFrame.empty() ? surfaces : inRootsFrame;
  if (follows)
    followed = followMotion(placed, rootMap, tree, pool, part(ofArcs, 0, followingShare),
                            parameters.closing, locators);
  overArcs(surfaces, tree, part(ofArcs, follows ? followingShare : 0, 1),
           [&](int i, const Progress&) {
             const int parent = tree.parent[i];
             if (std::optional<FollowedLayer>& layer = followed.layers[i]) {
               TransferredMap& read = layer->transferred;
               layers[i] = {std::move(read.map),
                            parent,
                            read.repairedFaces,
                            read.residual.mean,
                            read.residual.p95,
                            layer->seconds,
                            Route::Method,
                            {},
                            1,
                            std::move(read.distances)};
               return;
             }
             const Stopwatch watch;
             layers[i] = propagateArc(placed[parent], layers[parent]->map, placed[i], parameters);
             layers[i]->parent = parent;
             layers[i]->seconds = watch.seconds();
           });
  std::optional<MapDifference> closing;
  if (parameters.closing) {
    const auto [from, to] = *parameters.closing;
    if (followed.closing)
      closing = differenceOf(surfaces[to], followed.closing->carried, followed.closing->brought);
    else
      closing = differenceOf(
          surfaces[to], propagateArc(placed[from], layers[from]->map, placed[to], parameters).map,
          layers[to]->map);
  }
  // In a second round: children have read the map of their parent as it was.
  if (restores)
    overArcs(surfaces, tree, part(progress, propagationShare, 1),
             [&](int i, const Progress& ofLayer) {
               const Stopwatch watch;
               layers[i]->map =
                   restoreArea(surfaces[i], layers[i]->map, parameters.areaRestoration, ofLayer);
               layers[i]->seconds += watch.seconds();
             });
  Propagation result;
  result.learnt = followed.learnt;
  result.averaged = followed.averaged;
  result.closing = closing;
  result.layers.reserve(layers.size());
  for (size_t i = 0; i < layers.size(); ++i) {
    layers[i]->pose = poses[i];
    layers[i]->relativeSize = sizes[i];
    result.layers.push_back(std::move(*layers[i]));
  }
  return result;
}

}  // namespace sphere_propagation
