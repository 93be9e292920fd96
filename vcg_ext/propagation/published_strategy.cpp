// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/published_strategy.h"

#include "vcg_ext/base/stopwatch.h"

namespace sphere_propagation {

Propagation PublishedStrategy::propagate(const PropagationTask& task,
                                         const Progress& progress) const {
  Propagation result;
  result.layers = overArcs(task, progress, [&](int i, const PropagatedLayer& parent) {
    const Stopwatch watch;
    PropagatedLayer layer{
        propagateAsPublished(parent.map(), task.sequence.surface(i), parameters_)};
    layer.seconds = watch.seconds();
    return layer;
  });
  result.closing = overClosingArc(task, result.layers, [&](const MappedSurface& from, int to) {
    return propagateAsPublished(from, task.sequence.surface(to), parameters_).map;
  });
  return result;
}

}  // namespace sphere_propagation
