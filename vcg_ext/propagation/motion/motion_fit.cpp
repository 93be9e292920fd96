// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_fit.h"

#include <Eigen/Cholesky>
#include <utility>

#include "vcg_ext/propagation/motion/motion_data.h"

namespace sphere_propagation {
namespace {

/// What the data term says of each coefficient: the sum of w_i (B_i^T m_i) (B_i^T m_i)^T. Rough,
/// since it says how far to step, not where to.
Eigen::MatrixXd informationOf(const MotionModel& model, const MotionData& data) {
  return model.basis().roughInformation(data.directions, data.weights);
}

/// The gradient of the data term, for noise 1.
Eigen::VectorXd pullOf(const MotionModel& model, const MotionData& data) {
  return model.basis().roughProjectAll(data.pull);
}

/// Fits surface after surface. fitOne(fit so far, s, t): the arc from surface s to surface t.
template <class Function>
MotionFit overTree(const Sequence& sequence, const PropagationTree& tree, ThreadPool& pool,
                   const Progress& progress, const Function& fitOne) {
  MotionFit fit;
  const auto count = static_cast<size_t>(sequence.size());
  fit.coefficients.assign(count, Eigen::VectorXd::Zero(MotionBasis::columns));
  fit.equations.resize(count);
  fit.factors.resize(count);
  fit.lost.assign(count, 0);
  const std::vector<std::vector<int>> levels = tree.levels();
  size_t done = 1;
  for (size_t level = 1; level < levels.size(); ++level) {
    pool.forEach(static_cast<int>(levels[level].size()), [&](int k) {
      const auto t = static_cast<size_t>(levels[level][static_cast<size_t>(k)]);
      auto s = static_cast<size_t>(tree.parent[t]);
      while (fit.lost[s]) s = static_cast<size_t>(tree.parent[s]);  // the root is never lost
      ArcFit arc = fitOne(fit, s, t);
      fit.coefficients[t] = std::move(arc.coefficients);
      fit.equations[t] = std::move(arc.equations);
      fit.factors[t] = std::move(arc.factor);
      fit.lost[t] =
          arc.distance <= maxEdgesApart * sequence[static_cast<int>(t)].meanEdge() ? 0 : 1;
    });
    done += levels[level].size();
    report(progress, static_cast<double>(done) / static_cast<double>(count));
  }
  return fit;
}

/// fitArc with a prior that is wide enough.
ArcFit fitArcTo(const MotionModel& model, const PreparedSurface& target,
                const Eigen::VectorXd& before, const MotionPrior& prior,
                const Eigen::VectorXd& start, int iterations, const LayerAnchors* anchors) {
  ArcFit fit{before, {}, {}, 0};
  if (start.size() > 0)
    fit.coefficients += start;
  else if (anchors != nullptr)
    fit.coefficients += anchors->step(before, prior);
  std::vector<int> nearby(static_cast<size_t>(model.nodes().rows()), -1);
  ArcEquations& e = fit.equations;
  for (int i = 0; i < iterations; ++i) {
    const MotionData data = motionDataAt(model, target, fit.coefficients, nearby);
    if (i == 0 || start.size() == 0) {
      e.matrix = informationOf(model, data) / prior.noise;
      if (anchors != nullptr) e.matrix += anchors->information();
      fit.factor = DenseCholesky(e.matrix + prior.precision);
    }
    e.vector = pullOf(model, data) / prior.noise + e.matrix * (fit.coefficients - before);
    if (anchors != nullptr) e.vector += anchors->pull(fit.coefficients);
    fit.coefficients = before + fit.factor.solve(e.vector);
    fit.distance = data.distance;
  }
  return fit;
}

}  // namespace

ArcFit fitArc(const MotionModel& model, const PreparedSurface& target,
              const Eigen::VectorXd& before, const MotionPrior& prior, const Eigen::VectorXd& start,
              int iterations, const LayerAnchors* anchors) {
  const double wider = anchors == nullptr ? 1 : anchors->widening(before, prior);
  if (wider == 1) return fitArcTo(model, target, before, prior, start, iterations, anchors);
  return fitArcTo(model, target, before, {prior.precision / wider, prior.noise}, start, iterations,
                  anchors);
}

Eigen::VectorXd fitArcAgain(const MotionModel& model, const PreparedSurface& target,
                            const Eigen::VectorXd& before, const MotionPrior& prior,
                            const Eigen::VectorXd& start, const ArcSystem& system,
                            const LayerAnchors* anchors) {
  std::vector<int> nearby(static_cast<size_t>(model.nodes().rows()), -1);
  const MotionData data = motionDataAt(model, target, before + start, nearby);
  Eigen::VectorXd vector = pullOf(model, data) / prior.noise + system.matrix * start;
  if (anchors != nullptr) vector += anchors->pull(before + start);
  return before + system.factor.solve(vector);
}

MotionFit fitMotion(const MotionModel& model, const Sequence& sequence, const PropagationTree& tree,
                    const MotionPrior& prior, ThreadPool& pool, const Progress& progress,
                    const MotionAnchors& anchors) {
  return overTree(sequence, tree, pool, progress, [&](const MotionFit& fit, size_t s, size_t t) {
    return fitArc(model, sequence[static_cast<int>(t)], fit.coefficients[s], prior, {},
                  arcIterations, anchors.of(t));
  });
}

MotionFit refitMotion(const MotionModel& model, const Sequence& sequence,
                      const PropagationTree& tree, const MotionPrior& prior,
                      const std::vector<Eigen::VectorXd>& earlier, ThreadPool& pool,
                      const Progress& progress, const MotionAnchors& anchors) {
  return overTree(sequence, tree, pool, progress, [&](const MotionFit& fit, size_t s, size_t t) {
    return fitArc(model, sequence[static_cast<int>(t)], fit.coefficients[s], prior,
                  earlier[t] - earlier[s], arcIterationsAgain, anchors.of(t));
  });
}

}  // namespace sphere_propagation
