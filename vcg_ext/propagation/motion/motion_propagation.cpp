// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_propagation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/stopwatch.h"
#include "vcg_ext/propagation/motion/motion_anchors.h"
#include "vcg_ext/propagation/motion/motion_cycle.h"
#include "vcg_ext/propagation/motion/motion_fit.h"
#include "vcg_ext/propagation/motion/motion_learning.h"
#include "vcg_ext/propagation/motion/motion_model.h"
#include "vcg_ext/propagation/motion/motion_smoothing.h"
#include "vcg_ext/propagation/motion/motion_uncertainty.h"

namespace sphere_propagation {
namespace {

/// The map of a surface read off the moved root; empty where the fit lost the surface. order: of
/// the root's faces in a locator.
std::optional<TransferredMap> readMap(const MappedSurface& root, const std::vector<int>& order,
                                      const Points& moved, const PreparedSurface& layer) {
  try {
    TransferredMap map = transferMap(root, moved, layer.surface(), order);
    if (map.residual.mean <= maxEdgesApart * layer.meanEdge()) return map;
  } catch (const MapError&) {
    // Too far from a map to be repaired: lost as well.
  }
  return std::nullopt;
}

/// Whether the tree is one chain through the root, as those of time are.
bool isPath(const PropagationTree& tree) {
  const std::vector<std::vector<int>> children = tree.children();
  for (size_t t = 0; t < children.size(); ++t)
    if (children[t].size() > (static_cast<int>(t) == tree.root() ? 2U : 1U)) return false;
  return true;
}

/// The arcs between surfaces that the fit did not lose, the one that closes a cycle among them.
std::vector<Arc> arcsOf(const PropagationTree& tree, const ClosedCycle& cycle,
                        const std::vector<char>& lost) {
  const auto nearest = [&](int layer) {
    while (lost[static_cast<size_t>(layer)]) layer = tree.parent[static_cast<size_t>(layer)];
    return layer;
  };
  std::vector<Arc> arcs;
  for (int t : tree.order)
    if (t != tree.root() && !lost[static_cast<size_t>(t)])
      arcs.push_back({nearest(tree.parent[static_cast<size_t>(t)]), t});
  if (cycle.layers.empty()) return arcs;
  const size_t layers = cycle.layers.size(), end = static_cast<size_t>(cycle.forward);
  const Arc closing{nearest(cycle.layers[end]), nearest(cycle.layers[(end + 1) % layers])};
  if (closing.from != closing.to) arcs.push_back(closing);
  return arcs;
}

std::vector<AnchorFigures> figuresOf(const PropagationTree& tree, const MotionAnchors& held,
                                     const MotionFit& fit, const MotionPrior& prior,
                                     const AnchorPlaces& places) {
  const size_t count = places.names.size();
  const std::vector<double> unknown(count, std::nan(""));
  std::vector<AnchorFigures> figures(tree.parent.size(), {unknown, unknown, unknown});
  for (size_t t = 0; t < figures.size(); ++t) {
    const LayerAnchors* anchors = held.of(t);
    if (anchors == nullptr) continue;
    auto s = static_cast<size_t>(tree.parent[t]);
    while (fit.lost[s]) s = static_cast<size_t>(tree.parent[s]);  // as the fit does
    const Eigen::VectorXd& before = fit.coefficients[s];
    const std::vector<double> distances = anchors->distances(before),
                              standardised = anchors->standardised(before, prior);
    const std::vector<size_t> there = places.of(t);
    for (size_t i = 0; i < there.size(); ++i) {
      figures[t].before[there[i]] = distances[i];
      figures[t].standardised[there[i]] = standardised[i];
    }
    figures[t].widening = anchors->widening(before, prior);
    figures[t].exchanged = places.named(t, anchors->exchanged(before, prior));
  }
  return figures;
}

}  // namespace

FollowedMotion followMotion(const Sequence& sequence, const MappedSurface& root,
                            const PropagationTree& tree, ThreadPool& pool, const Progress& progress,
                            const std::optional<Arc>& closing, const MotionParameters& parameters,
                            const AnchorPlaces& anchors, const std::vector<double>& deviations) {
  const Stopwatch fitting;
  FollowedMotion followed;
  followed.layers.resize(static_cast<size_t>(sequence.size()));
  if (sequence.size() == 1) return followed;
  const MotionModel model(root);
  sequence.prepare(pool);
  const MotionAnchors held(model, sequence, tree.root(), root, anchors, deviations);
  const std::vector<int> rootOrder = sequence[tree.root()].locator().order();
  const bool learns = tree.size() - 1 >= parameters.minArcsToLearnFrom;
  MotionPrior prior = fixedMotionPrior();
  MotionFit fit;
  if (learns) {
    LearntPrior learnt =
        learnMotionPrior(model, sequence, tree, pool, part(progress, 0, 0.5), held);
    prior = std::move(learnt.prior);
    followed.learnt = learnt.variances;
    fit = refitMotion(model, sequence, tree, prior, learnt.coefficients, pool,
                      part(progress, 0.5, 0.75), held);
  } else {
    fit = fitMotion(model, sequence, tree, prior, pool, part(progress, 0, 0.75), held);
  }
  const ClosedCycle cycle = closing ? closedCycle(tree, *closing) : ClosedCycle{};
  const bool closes = !cycle.layers.empty();
  std::vector<Eigen::VectorXd> motion = fit.coefficients, around;
  if (closes) {
    around = fitOtherWayRound(model, sequence, cycle, fit, prior, pool, held);
    motion = averageOfBothWays(model, sequence, cycle, fit.coefficients, around);
  }
  std::vector<Eigen::MatrixXd> covariances(motion.size());
  if (parameters.uncertainty) {
    covariances = covariancesAlongTree(tree, fit, pool);
    std::vector<char> averaged(motion.size(), 0);
    for (size_t t = 0; t < motion.size(); ++t) averaged[t] = motion[t] != fit.coefficients[t];
    if (closes) covariances = covariancesOfBothWays(cycle, fit, averaged, std::move(covariances));
  }
  std::vector<char> smoothed(motion.size(), 0);
  if (parameters.smooths && learns && held.empty() && isPath(tree)) {
    SmoothedMotion all =
        smoothMotion(model, sequence, tree.root(), arcsOf(tree, cycle, fit.lost), motion,
                     priorForAllAtOnce(prior), pool, parameters.uncertainty);
    if (all.rootError.size() > 0) followed.rootError = interpolatedAt(model, root, all.rootError);
    for (size_t t = 0; t < motion.size(); ++t) {
      const Eigen::VectorXd& c = all.coefficients[t];
      if (c == motion[t] || !agree(model, sequence[static_cast<int>(t)], c, motion[t])) continue;
      motion[t] = c;
      smoothed[t] = 1;
      if (parameters.uncertainty) covariances[t] = std::move(all.covariances[t]);
    }
  }
  if (!anchors.empty()) followed.anchors = figuresOf(tree, held, fit, prior, anchors);
  const double share = fitting.seconds() / (sequence.size() - 1);

  const auto isThere = [&](int i) {
    return i == tree.root() || followed.layers[static_cast<size_t>(i)];
  };
  const auto read = [&](int layer, const Eigen::VectorXd& coefficients) {
    const auto i = static_cast<size_t>(layer);
    const Stopwatch reading;
    std::optional<TransferredMap> map =
        readMap(root, rootOrder, model.movedVertices(coefficients), sequence[layer]);
    if (!map) return;
    Eigen::VectorXd uncertainty;
    if (covariances[i].size() > 0)
      uncertainty =
          interpolatedAt(model, map->map, uncertaintyOfNodes(model, coefficients, covariances[i]));
    followed.layers[i] =
        FollowedLayer{std::move(*map), share + reading.seconds(), std::move(uncertainty)};
  };
  // No map needs another: many at a time, since a level of a tree in time has but two.
  constexpr int atOnce = 16;
  const int count = tree.size();
  for (int begin = 0; begin < count; begin += atOnce) {
    pool.forEach(std::min(atOnce, count - begin), [&](int k) {
      const int t = begin + k;
      const auto i = static_cast<size_t>(t);
      if (t == tree.root()) return;
      read(t, motion[i]);
      if (!isThere(t) && motion[i] != fit.coefficients[i]) {
        motion[i] = fit.coefficients[i];
        read(t, motion[i]);
      }
    });
    report(progress, 0.75 + 0.25 * std::min(begin + atOnce, count) / count);
  }
  if (closes)
    for (const bool forwardBranch : {true, false})
      for (const auto& [from, to] : cycle.arcsBeyond(forwardBranch))
        if (isThere(from) && !isThere(to)) read(to, around[static_cast<size_t>(to)]);
  for (size_t i = 0; i < motion.size(); ++i)
    if (motion[i] != fit.coefficients[i]) ++(smoothed[i] ? followed.smoothed : followed.averaged);
  if (closing && isThere(closing->from) && isThere(closing->to)) {
    const auto from = static_cast<size_t>(closing->from), to = static_cast<size_t>(closing->to);
    const auto mapOf = [&](const Eigen::VectorXd& coefficients) {
      return readMap(root, rootOrder, model.movedVertices(coefficients), sequence[closing->to]);
    };
    const bool beyond = closes && closing->to != tree.root();
    std::optional<TransferredMap> carried =
        mapOf(beyond ? around[to]
                     : fitArc(model, sequence[closing->to], fit.coefficients[from], prior, {},
                              arcIterations, held.of(to))
                           .coefficients);
    std::optional<TransferredMap> brought = mapOf(fit.coefficients[to]);
    if (carried && brought)
      followed.closing = ClosingMaps{std::move(carried->map), std::move(brought->map)};
  }
  return followed;
}

}  // namespace sphere_propagation
