#include "vcg_ext/propagation/motion_propagation.h"

#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/stopwatch.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

/// The map of a layer read off the moved root; empty where the fit lost the layer.
std::optional<TransferredMap> readMap(const ClosedSurface& root, const SphereMap& rootMap, const Points& moved,
                                      const ClosedSurface& layer) {
  try {
    TransferredMap map = transferMap(root, rootMap, moved, layer);
    const double most = mostResidualInEdges * meanEdgeLength(layer.vertices(), layer.faces());
    if (map.residual.mean <= most) return map;
  } catch (const MapError&) {
    // Too far from a map to be repaired: lost as well.
  }
  return std::nullopt;
}

}  // namespace

FollowedMotion followMotion(const std::vector<ClosedSurface>& surfaces, const SphereMap& rootMap,
                            const PropagationTree& tree, ThreadPool& pool, const Progress& progress,
                            const std::optional<Arc>& closing) {
  const Stopwatch fitting;
  const ClosedSurface& root = surfaces[static_cast<size_t>(tree.root())];
  FollowedMotion followed;
  followed.layers.resize(surfaces.size());
  if (surfaces.size() == 1) return followed;
  const MotionModel model(root, rootMap);
  const std::vector<MotionTarget> targets = motionTargets(surfaces, pool);
  const bool learns = tree.size() - 1 >= leastArcsToLearnFrom;
  MotionPrior prior = fixedMotionPrior();
  std::vector<Eigen::VectorXd> earlier;
  if (learns) {
    LearntPrior learnt = learnMotionPrior(model, targets, tree, pool, part(progress, 0, 0.5));
    prior = std::move(learnt.prior);
    followed.learnt = learnt.variances;
    earlier = std::move(learnt.coefficients);
  }
  const MotionFit fit = fitMotion(model, targets, tree, prior, pool, part(progress, learns ? 0.5 : 0, 0.75), earlier);
  const double share = fitting.seconds() / static_cast<double>(surfaces.size() - 1);

  size_t done = 0;
  for (const std::vector<int>& level : tree.levels()) {
    pool.forEach(static_cast<int>(level.size()), [&](int k) {
      const auto i = static_cast<size_t>(level[static_cast<size_t>(k)]);
      const int parent = tree.parent[i];
      const bool parentIsThere = parent == tree.root() || (parent >= 0 && followed.layers[static_cast<size_t>(parent)]);
      if (!parentIsThere) return;
      const Stopwatch reading;
      std::optional<TransferredMap> map = readMap(root, rootMap, model.movedVertices(fit.coefficients[i]), surfaces[i]);
      if (map) followed.layers[i] = FollowedLayer{std::move(*map), share + reading.seconds()};
    });
    done += level.size();
    report(progress, 0.75 + 0.25 * static_cast<double>(done) / static_cast<double>(surfaces.size()));
  }
  if (closing && (closing->from == tree.root() || followed.layers[static_cast<size_t>(closing->from)])) {
    const auto from = static_cast<size_t>(closing->from), to = static_cast<size_t>(closing->to);
    const ArcFit arc = fitArc(model, targets[to], fit.coefficients[from], prior);
    std::optional<TransferredMap> map = readMap(root, rootMap, model.movedVertices(arc.coefficients), surfaces[to]);
    if (map) followed.closing = std::move(map->map);
  }
  return followed;
}

}  // namespace sphere_propagation
