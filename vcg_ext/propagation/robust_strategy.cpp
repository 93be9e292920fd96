// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/robust_strategy.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/statistics.h"
#include "vcg_ext/base/stopwatch.h"
#include "vcg_ext/propagation/aligned/aligned_propagation.h"
#include "vcg_ext/propagation/published/published_propagation.h"

namespace sphere_propagation {
namespace {

/// Of the time, where no surface is lost.
constexpr double followingShare = 0.95;

/// Named is the one of the two that is of another size than most.
void requireOneUnit(const Sequence& sequence, const PropagationTree& tree) {
  std::vector<double> logs;
  for (int i = 0; i < sequence.size(); ++i) logs.push_back(std::log(sequence[i].radius()));
  const double usual = medianOf(logs);
  for (int i = 0; i < sequence.size(); ++i) {
    const int parent = tree.parent[static_cast<size_t>(i)];
    if (parent < 0) continue;
    const double ratio = sequence[i].radius() / sequence[parent].radius();
    if (ratio < maxRelativeSize && ratio > 1 / maxRelativeSize) continue;
    const bool oddParent =
        sequence.size() > 2 && std::fabs(logs[static_cast<size_t>(parent)] - usual) >
                                   std::fabs(logs[static_cast<size_t>(i)] - usual);
    throw ParameterError(Finding(Fault::DifferentUnits, sequence.name(oddParent ? parent : i))
                             .against(sequence.name(oddParent ? i : parent))
                             .saying((ratio > 1) != oddParent ? "larger" : "smaller")
                             .at(ratio > 1 ? ratio : 1 / ratio, 0, maxRelativeSize));
  }
}

/// What stands in for a fit that lost its surface.
PropagatedLayer fromParent(const MappedSurface& parent, const ClosedSurface& target) {
  try {
    PropagatedLayer layer{propagateAligned(parent, target)};
    layer.route = Route::Alignment;
    return layer;
  } catch (const MapError&) {
    PropagatedLayer layer{propagateAsPublished(parent, target)};
    layer.route = Route::Published;
    return layer;
  }
}

}  // namespace

Propagation RobustStrategy::propagate(const PropagationTask& task, const Progress& progress) const {
  requireOneUnit(task.sequence, task.tree);
  report(progress, 0);
  const Sequence sized = inRootsSize(task.sequence, task.sizes, task.tree);
  const std::vector<SurfacePose> poses =
      findSurfacePoses(sized, task.tree, task.pool, layByAnchors(task, sized));
  const Sequence laid = laidInRootsFrame(sized, poses);
  std::vector<double> deviations = task.anchorDeviations;
  for (size_t i = 0; i < deviations.size(); ++i)
    deviations[i] *=
        sized[static_cast<int>(i)].radius() / task.sequence[static_cast<int>(i)].radius();
  FollowedMotion followed =
      followMotion(laid, task.root, task.tree, task.pool, part(progress, 0, followingShare),
                   task.closing, parameters_, task.anchors, deviations);
  Propagation result;
  result.learnt = followed.learnt;
  result.averaged = followed.averaged;
  result.smoothed = followed.smoothed;
  result.rootError = std::move(followed.rootError);
  result.layers =
      overArcs(task, part(progress, followingShare, 1), [&](int i, const PropagatedLayer& parent) {
        if (std::optional<FollowedLayer>& layer = followed.layers[static_cast<size_t>(i)]) {
          PropagatedLayer there{std::move(layer->transferred)};
          there.seconds = layer->seconds;
          there.uncertainty = std::move(layer->uncertainty);
          return there;
        }
        const Stopwatch watch;
        PropagatedLayer there = fromParent(parent.map(), laid.surface(i));
        there.seconds = watch.seconds();
        return there;
      });
  if (followed.closing)  // what the fits say, nothing averaged
    result.closing = differenceOf(followed.closing->carried, followed.closing->brought);
  else
    result.closing = overClosingArc(task, result.layers, [&](const MappedSurface& from, int to) {
      return fromParent(from, laid.surface(to)).map();
    });
  // The maps are of the surfaces as they lie, and so are lengths.
  for (int i = 0; i < task.sequence.size(); ++i) {
    const auto k = static_cast<size_t>(i);
    TransferredMap& transferred = result.layers[k].transferred;
    transferred.map = transferred.map.of(task.sequence.surface(i));
    if (const double unit = task.sequence[i].radius() / sized[i].radius(); unit != 1) {
      for (double& distance : transferred.distances) distance *= unit;
      transferred.residual = residualOf(transferred.distances);
      result.layers[k].uncertainty *= unit;
      if (!followed.anchors.empty())
        for (double& distance : followed.anchors[k].before) distance *= unit;
    }
    if (!followed.anchors.empty()) result.layers[k].anchors = std::move(followed.anchors[k]);
    result.layers[k].pose = poses[k];
  }
  if (parameters_.uncertainty)
    result.layers[static_cast<size_t>(task.tree.root())].uncertainty =
        Eigen::VectorXd::Zero(task.root.vertexCount());
  return result;
}

}  // namespace sphere_propagation
