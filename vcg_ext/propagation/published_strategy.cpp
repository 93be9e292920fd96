// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/published_strategy.h"

#include <utility>

#include "vcg_ext/base/stopwatch.h"
#include "vcg_ext/propagation/motion/motion_anchors.h"
#include "vcg_ext/propagation/motion/motion_model.h"

namespace sphere_propagation {

namespace {

/// The corner of each anchor's face that it is nearest to, at the place of the root's anchor.
std::vector<NodeAt> anchorsOf(const PropagationTask& task, size_t layer) {
  std::vector<NodeAt> nodes;
  const auto root = static_cast<size_t>(task.tree.root());
  for (const size_t k : task.anchors.of(layer)) {
    const SurfacePoint &there = task.anchors.points[layer][k],
                       &ofRoot = task.anchors.points[root][k];
    Eigen::Index corner = 0;
    there.weights.maxCoeff(&corner);
    nodes.push_back({task.sequence.surface(static_cast<int>(layer)).faces()(there.face, corner),
                     ofRoot.interpolate(task.root.faces(), task.root.positions()).normalized()});
  }
  return nodes;
}

/// By layer, the anchors whose names are exchanged in all likelihood. The method has no prior that
/// could tell, so method Robust's fixed one does, along motions that fit it and the anchors alone.
std::vector<std::vector<std::vector<size_t>>> exchangedAnchors(
    const PropagationTask& task, const std::vector<SurfacePose>& byAnchors) {
  std::vector<std::vector<std::vector<size_t>>> exchanged(task.tree.parent.size());
  if (task.anchors.empty()) return exchanged;
  const Sequence laid = laidInRootsFrame(
      task.sequence, findSurfacePoses(task.sequence, task.tree, task.pool, byAnchors));
  const MotionModel model(task.root);
  const MotionAnchors held(model, laid, task.tree.root(), task.root, task.anchors,
                           task.anchorDeviations);
  const MotionPrior prior = fixedMotionPrior();
  std::vector<Eigen::VectorXd> motion(exchanged.size(),
                                      Eigen::VectorXd::Zero(MotionBasis::columns));
  for (const std::vector<int>& level : task.tree.levels())
    for (const int layer : level) {
      const auto t = static_cast<size_t>(layer);
      if (layer == task.tree.root()) continue;
      const Eigen::VectorXd before = motion[static_cast<size_t>(task.tree.parent[t])];
      motion[t] = before;
      const LayerAnchors* anchors = held.of(t);
      if (anchors == nullptr) continue;
      exchanged[t] = task.anchors.named(t, anchors->exchanged(before, prior));
      if (exchanged[t].empty()) motion[t] += anchors->step(before, prior);
    }
  return exchanged;
}

}  // namespace

Propagation PublishedStrategy::propagate(const PropagationTask& task,
                                         const Progress& progress) const {
  const std::vector<SurfacePose> poses = layByAnchors(task, task.sequence);
  const Sequence laid = poses.empty() ? task.sequence : laidInRootsFrame(task.sequence, poses);
  Propagation result;
  result.layers = overArcs(task, progress, [&](int i, const PropagatedLayer& parent) {
    const Stopwatch watch;
    PropagatedLayer layer{propagateAsPublished(parent.map(), laid.surface(i), parameters_,
                                               anchorsOf(task, static_cast<size_t>(i)))};
    layer.seconds = watch.seconds();
    return layer;
  });
  result.closing = overClosingArc(task, result.layers, [&](const MappedSurface& from, int to) {
    return propagateAsPublished(from, laid.surface(to), parameters_,
                                anchorsOf(task, static_cast<size_t>(to)))
        .map;
  });
  if (!task.anchors.empty()) {
    std::vector<std::vector<std::vector<size_t>>> exchanged = exchangedAnchors(task, poses);
    for (size_t i = 0; i < exchanged.size(); ++i)
      result.layers[i].anchors.exchanged = std::move(exchanged[i]);
  }
  // The maps are of the surfaces as they lie.
  for (size_t i = 0; i < poses.size(); ++i) {
    result.layers[i].pose = poses[i];
    MappedSurface& map = result.layers[i].transferred.map;
    map = map.of(task.sequence.surface(static_cast<int>(i)));
  }
  return result;
}

}  // namespace sphere_propagation
