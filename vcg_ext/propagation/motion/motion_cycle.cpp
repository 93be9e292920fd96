// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_cycle.h"

#include <cstddef>
#include <utility>

namespace sphere_propagation {

std::vector<Eigen::VectorXd> fitOtherWayRound(const MotionModel& model, const Sequence& sequence,
                                              const ClosedCycle& cycle, const MotionFit& fit,
                                              const MotionPrior& prior, ThreadPool& pool,
                                              const MotionAnchors& anchors) {
  const std::vector<Eigen::VectorXd>& brought = fit.coefficients;
  std::vector<Eigen::VectorXd> around(brought.size(), Eigen::VectorXd::Zero(MotionBasis::columns));
  pool.forEach(2, [&](int chain) {
    // The branch's last surface that was not lost; the root never is.
    const size_t layers = cycle.layers.size();
    size_t place = static_cast<size_t>(cycle.forward) + (chain == 0 ? 0 : 1);
    const auto layerThere = [&] { return static_cast<size_t>(cycle.layers[place % layers]); };
    while (fit.lost[layerThere()]) chain == 0 ? --place : ++place;
    Eigen::VectorXd here = brought[layerThere()];
    for (const auto& [start, end] : cycle.arcsBeyond(chain == 0)) {
      const auto from = static_cast<size_t>(start), to = static_cast<size_t>(end);
      // It starts beside what the tree brought to the surface, as far as it was beside it before:
      // the nodes lie on the surface then, and one iteration does.
      if (!fit.lost[from] && !fit.lost[to]) {
        here = fitArcAgain(model, sequence[end], here, prior, brought[to] - brought[from],
                           {fit.equations[to].matrix, fit.factors[to]}, anchors.of(to));
        around[to] = here;
        continue;
      }
      ArcFit arc = fitArc(model, sequence[end], here, prior, {}, arcIterations, anchors.of(to));
      around[to] = arc.coefficients;
      if (!fit.lost[to])
        here = std::move(arc.coefficients);  // what does not belong to the others leads nowhere
    }
  });
  return around;
}

bool agree(const MotionModel& model, const PreparedSurface& layer, const Eigen::VectorXd& a,
           const Eigen::VectorXd& b) {
  const Points apart = model.movedNodes(a - b) - model.nodes();
  return apart.rowwise().norm().mean() <= maxEdgesApart * layer.meanEdge();
}

double forwardShare(int step, int surfaces) { return 0.75 - 0.5 * step / surfaces; }

std::vector<Eigen::VectorXd> averageOfBothWays(const MotionModel& model, const Sequence& sequence,
                                               const ClosedCycle& cycle,
                                               const std::vector<Eigen::VectorXd>& brought,
                                               const std::vector<Eigen::VectorXd>& otherWayRound) {
  std::vector<Eigen::VectorXd> average = brought;
  const int surfaces = static_cast<int>(cycle.layers.size());
  for (int step = 1; step < surfaces; ++step) {
    const auto t = static_cast<size_t>(cycle.layers[static_cast<size_t>(step)]);
    if (!agree(model, sequence[static_cast<int>(t)], otherWayRound[t], brought[t])) continue;
    const Eigen::VectorXd apart = otherWayRound[t] - brought[t];
    const double forward = forwardShare(step, surfaces);
    average[t] += (step <= cycle.forward ? 1 - forward : forward) * apart;
  }
  return average;
}

}  // namespace sphere_propagation
