// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/propagation.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "vcg_ext/anchors/exact_map.h"
#include "vcg_ext/area/area_restoration.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/base/statistics.h"
#include "vcg_ext/base/stopwatch.h"
#include "vcg_ext/propagation/published_strategy.h"
#include "vcg_ext/propagation/robust_strategy.h"
#include "vcg_ext/sphere/sphere_locator.h"

namespace sphere_propagation {
namespace {

/// Of the time, where areas are restored: that takes several times as long as an arc.
constexpr double propagationShare = 0.2;

void requireFit(const Sequence& sequence, const MappedSurface& root, const PropagationTree& tree,
                const std::optional<Arc>& closing) {
  const auto layers = static_cast<size_t>(sequence.size());
  if (layers == 0 || tree.parent.size() != layers || tree.order.size() != layers)
    throw ArgumentError("The order of propagation is one of " + std::to_string(tree.parent.size()) +
                        " surfaces, but there are " + std::to_string(layers) + ".");
  if (closing)
    for (int i : {closing->from, closing->to})
      if (i < 0 || i >= sequence.size())
        throw ArgumentError("The arc that closes the cycle joins surface " + std::to_string(i) +
                            ", which does not exist.");
  root.of(sequence.surface(tree.root()));  // throws where the map is another surface's
}

/// Of surfaces that have a map like the others' the residual, in radii, is at most 2.5 times as
/// large as theirs; with one that a bad arc stretches (skulls of twelve species), 4.5 times.
constexpr double muchFarther = 3, deviationsFarther = 6, edgesFarther = 0.5;

/// The root's anchors on all surfaces.
AnchorPlaces placesOf(const AnchorParameters& anchors, const Sequence& sequence, int root) {
  AnchorPlaces places;
  if (anchors.use == AnchorUse::Off || anchors.layers.empty()) return places;
  if (anchors.layers.size() != static_cast<size_t>(sequence.size()))
    throw ArgumentError("There are anchors of " + std::to_string(anchors.layers.size()) +
                        " surfaces, but " + std::to_string(sequence.size()) + " surfaces.");
  for (const auto& [name, point] : anchors.layers[static_cast<size_t>(root)])
    places.names.push_back(name);
  if (places.names.empty()) return places;
  for (int i = 0; i < sequence.size(); ++i) {
    const AnchorSet& ofLayer = anchors.layers[static_cast<size_t>(i)];
    places.points.push_back(ofLayer.empty()
                                ? std::vector<SurfacePoint>(places.names.size())
                                : closestPoints(sequence[i].locator(), ofLayer, places.names));
  }
  return places;
}

/// The places of the root's anchors on the sphere.
std::vector<Vector3> placesOnSphere(const MappedSurface& root,
                                    const std::vector<SurfacePoint>& points) {
  std::vector<Vector3> places;
  for (const SurfacePoint& point : points) places.push_back(placeOf(root, point));
  return places;
}

/// Moves the map of a surface until it holds its anchors.
void holdAnchors(PropagatedLayer& layer, const std::vector<size_t>& there,
                 const std::vector<SurfacePoint>& points, const std::vector<Vector3>& places,
                 const std::vector<std::string>& names) {
  std::vector<SurfacePoint> its;
  std::vector<Vector3> targets;
  std::vector<std::string> called;
  for (const size_t k : there) {
    its.push_back(points[k]);
    targets.push_back(places[k]);
    called.push_back(names[k]);
  }
  ExactMap exact = holdExactly(layer.map(), its, targets, called);
  layer.transferred.map = std::move(exact.map);
  layer.transferred.repairedFaces += exact.untangledFaces;
}

/// How far each anchor lies from what the surface's map has at the root's place.
void measureAnchors(PropagatedLayer& layer, const std::vector<size_t>& there,
                    const std::vector<SurfacePoint>& points, const std::vector<Vector3>& places) {
  const std::vector<double> unknown(places.size(), std::nan(""));
  AnchorFigures& figures = layer.anchors;
  for (std::vector<double>* numbers : {&figures.before, &figures.after, &figures.standardised})
    if (numbers->empty()) *numbers = unknown;
  const SphereLocator under(layer.map());
  const Points& vertices = layer.map().surface().vertices();
  for (const size_t k : there) {
    const Vector3 mapped = under.locate(places[k]).interpolate(layer.map().faces(), vertices);
    figures.after[k] = (mapped - points[k].interpolate(layer.map().faces(), vertices)).norm();
  }
}

std::unique_ptr<PropagationStrategy> strategyOf(const PropagationParameters& parameters) {
  if (parameters.method == PropagationMethod::AsPublished)
    return std::make_unique<PublishedStrategy>(parameters.published);
  return std::make_unique<RobustStrategy>(parameters.motion);
}

}  // namespace

std::vector<char> residualsThatStandOut(const Sequence& sequence,
                                        const std::vector<PropagatedLayer>& layers) {
  std::vector<double> logs(layers.size(), 0), known;
  std::vector<char> standsOut(layers.size(), 0);
  for (size_t i = 0; i < layers.size(); ++i) {
    const double mean = layers[i].transferred.residual.mean;
    if (layers[i].parent < 0 || !(mean > 0)) continue;
    logs[i] = std::log(mean / sequence[static_cast<int>(i)].radius());
    known.push_back(logs[i]);
  }
  if (known.size() < 3) return standsOut;  // of two nobody knows which is right
  const RobustSpread usual = robustSpreadOf(std::move(known));
  const double most = std::max(std::log(muchFarther), deviationsFarther * usual.deviation);
  for (size_t i = 0; i < layers.size(); ++i) {
    const double mean = layers[i].transferred.residual.mean;
    standsOut[i] = layers[i].parent >= 0 && mean > 0 && logs[i] > usual.middle + most &&
                           mean > edgesFarther * sequence[static_cast<int>(i)].meanEdge()
                       ? 1
                       : 0;
  }
  return standsOut;
}

void requireValid(const PropagationParameters& parameters) {
  requireRange("area restoration", parameters.areaRestoration, Range::between(0, 1));
  requireRange("number of threads", parameters.threads, Range::atLeast(0));
  requireRange("standard deviation of anchors", parameters.anchors.deviation, Range::atLeast(0));
}

Propagation propagate(const Sequence& sequence, const MappedSurface& root,
                      const PropagationTree& tree, const PropagationParameters& parameters,
                      const Progress& progress) {
  requireValid(parameters);
  ThreadPool pool(parameters.threads);
  return propagate(sequence, root, tree, pool, parameters, progress);
}

Propagation propagate(const Sequence& sequence, const MappedSurface& root,
                      const PropagationTree& tree, ThreadPool& pool,
                      const PropagationParameters& parameters, const Progress& progress) {
  requireValid(parameters);
  requireFit(sequence, root, tree, parameters.closing);
  const bool restores = parameters.areaRestoration > 0;
  const std::vector<SurfaceSize> sizes = findSurfaceSizes(sequence, tree);
  const AnchorPlaces places = placesOf(parameters.anchors, sequence, tree.root());
  std::vector<double> deviations;
  for (int i = 0; i < sequence.size() && !places.empty(); ++i)
    deviations.push_back(parameters.anchors.deviation > 0 ? parameters.anchors.deviation
                                                          : sequence[i].meanEdge());
  const PropagationTask task{sequence, root,   tree,       parameters.closing,         sizes,
                             pool,     places, deviations, parameters.anchors.layPoses};
  Propagation result =
      strategyOf(parameters)->propagate(task, part(progress, 0, restores ? propagationShare : 1));
  const std::vector<char> farther = residualsThatStandOut(sequence, result.layers);
  for (size_t i = 0; i < sizes.size(); ++i) {
    result.layers[i].size = sizes[i];
    result.layers[i].residualStandsOut = farther[i] != 0;
  }
  if (restores) {
    // In a second round: children have read the map of their parent as it was.
    const Progress ofRestoration = part(progress, propagationShare, 1);
    for (int i = 0, done = 0; i < sequence.size(); ++i) {
      if (i == tree.root()) continue;
      const double arcs = sequence.size() - 1;
      const Stopwatch watch;
      PropagatedLayer& layer = result.layers[static_cast<size_t>(i)];
      layer.transferred.map = restoreArea(layer.map(), parameters.areaRestoration,
                                          part(ofRestoration, done / arcs, (done + 1) / arcs));
      layer.seconds += watch.seconds();
      ++done;
    }
  }
  if (!places.empty()) {
    // Last of all, as restoring areas moves what was held.
    const std::vector<Vector3> onSphere =
        placesOnSphere(root, places.points[static_cast<size_t>(tree.root())]);
    pool.forEach(sequence.size(), [&](int i) {
      const auto k = static_cast<size_t>(i);
      const std::vector<size_t> there = places.of(k);
      if (parameters.anchors.use == AnchorUse::Exact && i != tree.root() && !there.empty())
        holdAnchors(result.layers[k], there, places.points[k], onSphere, places.names);
      measureAnchors(result.layers[k], there, places.points[k], onSphere);
    });
  }
  report(progress, 1);
  return result;
}

}  // namespace sphere_propagation
