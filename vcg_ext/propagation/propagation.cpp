// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/propagation.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "vcg_ext/area/area_restoration.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/base/statistics.h"
#include "vcg_ext/base/stopwatch.h"
#include "vcg_ext/propagation/published_strategy.h"
#include "vcg_ext/propagation/robust_strategy.h"

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

/// Of layers that have a map like the others' the residual, in radii, is at most 2.5 times as large
/// as theirs; with one that a bad arc stretches (skulls of twelve species), 4.5 times.
constexpr double muchFarther = 3, deviationsFarther = 6, edgesFarther = 0.5;

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
}

Propagation propagate(const Sequence& sequence, const MappedSurface& root,
                      const PropagationTree& tree, const PropagationParameters& parameters,
                      const Progress& progress) {
  requireValid(parameters);
  requireFit(sequence, root, tree, parameters.closing);
  const bool restores = parameters.areaRestoration > 0;
  ThreadPool pool(parameters.threads);
  const std::vector<LayerSize> sizes = findLayerSizes(sequence, tree);
  const PropagationTask task{sequence, root, tree, parameters.closing, sizes, pool};
  Propagation result =
      strategyOf(parameters)->propagate(task, part(progress, 0, restores ? propagationShare : 1));
  const std::vector<char> farther = residualsThatStandOut(sequence, result.layers);
  for (size_t i = 0; i < sizes.size(); ++i) {
    result.layers[i].size = sizes[i];
    result.layers[i].residualStandsOut = farther[i] != 0;
  }
  if (!restores) return result;
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
  report(progress, 1);
  return result;
}

}  // namespace sphere_propagation
