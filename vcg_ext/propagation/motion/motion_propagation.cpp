// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_propagation.h"

#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/stopwatch.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/propagation/motion/motion_cycle.h"

namespace sphere_propagation {
namespace {

/// The map of a layer read off the moved root; empty where the fit lost the layer. order: of the
/// root's faces in a locator.
std::optional<TransferredMap> readMap(const ClosedSurface& root, const SphereMap& rootMap,
                                      const std::vector<int>& order, const Points& moved,
                                      const ClosedSurface& layer) {
  try {
    TransferredMap map = transferMap(root, rootMap, moved, layer, order);
    const double most = maxResidualInEdges * meanEdgeLength(layer.vertices(), layer.faces());
    if (map.residual.mean <= most) return map;
  } catch (const MapError&) {
    // Too far from a map to be repaired: lost as well.
  }
  return std::nullopt;
}

}  // namespace

FollowedMotion followMotion(const std::vector<ClosedSurface>& surfaces, const SphereMap& rootMap,
                            const PropagationTree& tree, ThreadPool& pool, const Progress& progress,
                            const std::optional<Arc>& closing, const LayerLocators& locators) {
  const Stopwatch fitting;
  const ClosedSurface& root = surfaces[static_cast<size_t>(tree.root())];
  FollowedMotion followed;
  followed.layers.resize(surfaces.size());
  if (surfaces.size() == 1) return followed;
  const MotionModel model(root, rootMap);
  const std::vector<MotionTarget> targets = motionTargets(surfaces, pool, locators);
  const std::vector<int> rootOrder = targets[static_cast<size_t>(tree.root())].locator->order();
  const bool learns = tree.size() - 1 >= minArcsToLearnFrom;
  MotionPrior prior = fixedMotionPrior();
  MotionFit fit;
  if (learns) {
    LearntPrior learnt = learnMotionPrior(model, targets, tree, pool, part(progress, 0, 0.5));
    prior = std::move(learnt.prior);
    followed.learnt = learnt.variances;
    fit = refitMotion(model, targets, tree, prior, learnt.coefficients, pool,
                      part(progress, 0.5, 0.75));
  } else {
    fit = fitMotion(model, targets, tree, prior, pool, part(progress, 0, 0.75));
  }
  const ClosedCycle cycle = closing ? closedCycle(tree, *closing) : ClosedCycle{};
  const bool closes = !cycle.layers.empty();
  std::vector<Eigen::VectorXd> motion = fit.coefficients, around;
  if (closes) {
    around = fitOtherWayRound(model, targets, cycle, fit, prior, pool);
    motion = averageOfBothWays(model, targets, cycle, fit.coefficients, around);
  }
  const double share = fitting.seconds() / static_cast<double>(surfaces.size() - 1);

  const auto isThere = [&](int i) {
    return i == tree.root() || followed.layers[static_cast<size_t>(i)];
  };
  const auto read = [&](int layer, const Eigen::VectorXd& coefficients) {
    const auto i = static_cast<size_t>(layer);
    const Stopwatch reading;
    std::optional<TransferredMap> map =
        readMap(root, rootMap, rootOrder, model.movedVertices(coefficients), surfaces[i]);
    if (map) followed.layers[i] = FollowedLayer{std::move(*map), share + reading.seconds()};
  };
  size_t done = 0;
  for (const std::vector<int>& level : tree.levels()) {
    pool.forEach(static_cast<int>(level.size()), [&](int k) {
      const int t = level[static_cast<size_t>(k)];
      const auto i = static_cast<size_t>(t);
      if (t == tree.root()) return;
      read(t, motion[i]);
      if (!isThere(t) && motion[i] != fit.coefficients[i]) {
        motion[i] = fit.coefficients[i];
        read(t, motion[i]);
      }
    });
    done += level.size();
    report(progress,
           0.75 + 0.25 * static_cast<double>(done) / static_cast<double>(surfaces.size()));
  }
  if (closes)
    for (const bool forwardBranch : {true, false})
      for (const auto& [from, to] : cycle.arcsBeyond(forwardBranch))
        if (isThere(from) && !isThere(to)) read(to, around[static_cast<size_t>(to)]);
  for (size_t i = 0; i < motion.size(); ++i)
    followed.averaged += motion[i] != fit.coefficients[i] ? 1 : 0;
  if (closing && isThere(closing->from) && isThere(closing->to)) {
    const auto from = static_cast<size_t>(closing->from), to = static_cast<size_t>(closing->to);
    const auto mapOf = [&](const Eigen::VectorXd& coefficients) {
      return readMap(root, rootMap, rootOrder, model.movedVertices(coefficients), surfaces[to]);
    };
    const bool beyond = closes && closing->to != tree.root();
    std::optional<TransferredMap> carried =
        mapOf(beyond ? around[to]
                     : fitArc(model, targets[to], fit.coefficients[from], prior).coefficients);
    std::optional<TransferredMap> brought = mapOf(fit.coefficients[to]);
    if (carried && brought)
      followed.closing = ClosingMaps{std::move(carried->map), std::move(brought->map)};
  }
  return followed;
}

}  // namespace sphere_propagation
