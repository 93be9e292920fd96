// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/strategy.h"

#include <cmath>
#include <string>
#include <utility>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {

std::vector<SurfacePose> layByAnchors(const PropagationTask& task, const Sequence& sequence) {
  if (!task.anchorsLayPoses || task.anchors.empty()) return {};
  std::vector<Points> anchors;
  for (int i = 0; i < sequence.size(); ++i) {
    const ClosedSurface& surface = sequence.surface(i);
    anchors.push_back(
        Points::Constant(static_cast<Eigen::Index>(task.anchors.names.size()), 3, std::nan("")));
    for (const size_t k : task.anchors.of(static_cast<size_t>(i)))
      anchors.back().row(static_cast<Eigen::Index>(k)) =
          task.anchors.points[static_cast<size_t>(i)][k]
              .interpolate(surface.faces(), surface.vertices())
              .transpose();
  }
  return posesByAnchors(sequence, task.tree.root(), anchors);
}

std::vector<PropagatedLayer> overArcs(
    const PropagationTask& task, const Progress& progress,
    const std::function<PropagatedLayer(int i, const PropagatedLayer& parent)>& make) {
  const PropagationTree& tree = task.tree;
  std::vector<std::optional<PropagatedLayer>> made(static_cast<size_t>(tree.size()));
  double vertices = 0, done = 0;
  for (int i : tree.order)
    if (i != tree.root()) vertices += task.sequence.surface(i).vertexCount();
  for (int i : tree.order) {
    const auto k = static_cast<size_t>(i);
    if (i == tree.root()) {
      const auto count = static_cast<size_t>(task.root.vertexCount());
      made[k] = PropagatedLayer{TransferredMap{task.root, 0, {}, std::vector<double>(count, 0)}};
      continue;
    }
    const int parent = tree.parent[k];
    try {
      made[k] = make(i, *made[static_cast<size_t>(parent)]);
    } catch (const MapError& error) {  // names the target, but knows nothing of the tree
      throw MapError(Finding(error.finding()).against(task.sequence.name(parent)));
    }
    made[k]->parent = parent;
    done += task.sequence.surface(i).vertexCount();
    report(progress, done / vertices);
  }
  report(progress, 1);
  std::vector<PropagatedLayer> layers;
  layers.reserve(made.size());
  for (std::optional<PropagatedLayer>& layer : made) layers.push_back(std::move(*layer));
  return layers;
}

std::optional<MapDifference> overClosingArc(
    const PropagationTask& task, const std::vector<PropagatedLayer>& layers,
    const std::function<MappedSurface(const MappedSurface& from, int to)>& carry) {
  if (!task.closing) return std::nullopt;
  const Arc& arc = *task.closing;
  return differenceOf(carry(layers[static_cast<size_t>(arc.from)].map(), arc.to),
                      layers[static_cast<size_t>(arc.to)].map());
}

}  // namespace sphere_propagation
