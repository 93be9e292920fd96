// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_learning.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "vcg_ext/base/conjugate_gradients.h"
#include "vcg_ext/base/dense_cholesky.h"
#include "vcg_ext/propagation/motion/dense_kernels.h"
#include "vcg_ext/propagation/motion/motion_fit.h"

namespace sphere_propagation {
namespace {

constexpr int local = MotionBasis::localColumns, affine = MotionBasis::affineColumns,
              all = MotionBasis::columns;

// Learning, all variances in units of A0/2.
constexpr MotionVariances wideVariances{1, 2, 1, 0.5}, startVariances{0.15, 0.5, 0.5, 0.2};
constexpr double wideNoise = 6, temperedNoise = 12, learntNoise = 2.5;
constexpr double varianceFloor = 0.015;
constexpr int varianceRounds = 100, covarianceRounds = 12;
constexpr ConjugateGradientParameters solved{1e-6, all};
constexpr double overEstimated = 0.1;  // share that is kept: the evidence over-estimates strain,
                                       // and twists likewise
constexpr double priorArcs = 16;       // what the diagonal covariance counts against the arcs

/// (A + D^-1)^-1 a, the system of an arc with the local coefficients integrated out: affine ones
/// first, then twists.
struct GlobalSystem {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd vector;
};

/// twists: local coefficients of fields that come beside the affine ones, one a column.
GlobalSystem withoutLocal(const ArcEquations& e, double localVariance,
                          const Eigen::MatrixXd& twists) {
  const Eigen::Index count = affine + twists.cols();
  Eigen::MatrixXd inner = e.matrix.topLeftCorner(local, local);
  Eigen::MatrixXd right(local, count + 1);
  right << e.matrix.topRightCorner(local, affine), inner * twists, e.vector.head(local);
  inner.diagonal().array() += 1 / localVariance;
  Eigen::MatrixXd mixed(count, local), matrix(count, count);
  mixed << e.matrix.bottomLeftCorner(affine, local),
      right.middleCols(affine, twists.cols()).transpose();
  matrix << e.matrix.bottomRightCorner(affine, affine), mixed.topRows(affine) * twists,
      twists.transpose() * right.leftCols(affine),
      twists.transpose() * right.middleCols(affine, twists.cols());
  Eigen::VectorXd vector(count);
  vector << e.vector.tail(affine), twists.transpose() * e.vector.head(local);
  const Eigen::MatrixXd solved = DenseCholesky(std::move(inner)).solve(std::move(right));
  return {matrix - mixed * solved.leftCols(count), vector - mixed * solved.col(count)};
}

/// Solves (H + precision) c = h, from the c that is given. inverse: that of a similar matrix.
void solve(const ArcEquations& e, const Eigen::MatrixXd& precision, const Eigen::MatrixXd& inverse,
           Eigen::VectorXd& c) {
  const Eigen::MatrixXd system = e.matrix + precision;
  solveByConjugateGradients([&](const Eigen::VectorXd& x) { return system * x; },
                            [&](const Eigen::VectorXd& rest) { return inverse * rest; }, e.vector,
                            c, solved);
}

/// Those of the blocks, and one of all twists.
struct GlobalVariances {
  MotionVariances blocks = startVariances;
  double twist = startVariances.rotation;
};

GlobalVariances learnVariances(const std::vector<ArcEquations>& equations,
                               const Eigen::MatrixXd& twists, ThreadPool& pool) {
  const Eigen::Index twisting = twists.cols();
  const std::vector<GlobalSystem> systems =
      pool.makeEach(static_cast<int>(equations.size()), [&](int k) {
        return withoutLocal(equations[static_cast<size_t>(k)], startVariances.local, twists);
      });
  GlobalVariances learnt;
  MotionVariances& variances = learnt.blocks;
  for (int round = 0; round < varianceRounds; ++round) {
    Eigen::VectorXd precision(affine + twisting);
    precision << variances.diagonal().tail(affine).cwiseInverse(),
        Eigen::VectorXd::Constant(twisting, 1 / learnt.twist);
    Eigen::VectorXd second = Eigen::VectorXd::Zero(precision.size());
    for (const GlobalSystem& system : systems) {
      Eigen::MatrixXd matrix = system.matrix;
      matrix.diagonal() += precision;
      const Eigen::MatrixXd covariance = matrix.inverse();
      second += (covariance * system.vector).cwiseAbs2() + covariance.diagonal();
    }
    second /= static_cast<double>(systems.size());
    const auto mean = [&](int from, int count) {
      return std::max(second.segment(from, count).mean(), varianceFloor);
    };
    const MotionVariances updated{variances.local, mean(0, 3), mean(3, 6), mean(9, 3)};
    const double change =
        std::max({std::fabs(std::log(updated.translation / variances.translation)),
                  std::fabs(std::log(updated.strain / variances.strain)),
                  std::fabs(std::log(updated.rotation / variances.rotation))});
    variances = updated;
    if (twisting > 0) learnt.twist = mean(affine, static_cast<int>(twisting));
    if (change < 1e-3) break;
  }
  variances.strain *= overEstimated;
  learnt.twist *= overEstimated;
  return learnt;
}

}  // namespace

LearntPrior learnMotionPrior(const MotionModel& model, const Sequence& sequence,
                             const PropagationTree& tree, ThreadPool& pool,
                             const Progress& progress, const MotionAnchors& anchors) {
  const MotionPrior wide = MotionPrior::of(wideVariances, wideNoise);
  LearntPrior learnt;
  MotionFit fit = fitMotion(model, sequence, tree, wide, pool, part(progress, 0, 0.7), anchors);
  std::vector<ArcEquations> equations;
  const double temper = wideNoise / temperedNoise, unit = std::sqrt(0.5 * model.meanVertexArea());
  for (const bool lostToo :
       {false, true}) {  // what is lost teaches nothing, unless there is nothing else
    for (size_t t = 0; t < fit.equations.size(); ++t) {
      const ArcEquations& e = fit.equations[t];
      if (e.vector.size() > 0 && (lostToo || !fit.lost[t]))
        equations.push_back({temper * e.matrix, temper / unit * e.vector});
    }
    if (!equations.empty()) break;
  }
  const Eigen::MatrixXd twists =
      anchors.empty() ? Eigen::MatrixXd(local, 0) : model.basis().twists();
  const GlobalVariances variances = learnVariances(equations, twists, pool);
  learnt.variances = variances.blocks;
  Eigen::MatrixXd towards = learnt.variances.diagonal().asDiagonal();
  towards.topLeftCorner(local, local) += variances.twist * twists * twists.transpose();
  const double count = static_cast<double>(equations.size());
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(all, all), covariance = towards;
  for (const ArcEquations& e : equations) mean += e.matrix / count;
  std::vector<Eigen::VectorXd> expected(equations.size(), Eigen::VectorXd::Zero(all));
  Eigen::MatrixXd found(all, static_cast<Eigen::Index>(equations.size()));
  for (int round = 0; round < covarianceRounds; ++round) {
    const Eigen::MatrixXd precision = inverseOf(covariance),
                          uncertainty = inverseOf(mean + precision);
    pool.forEach(static_cast<int>(equations.size()), [&](int k) {
      const auto i = static_cast<size_t>(k);
      solve(equations[i], precision, uncertainty, expected[i]);
    });
    for (size_t k = 0; k < expected.size(); ++k)
      found.col(static_cast<Eigen::Index>(k)) = expected[k];
    covariance = priorArcs * towards + count * uncertainty;
    covariance.noalias() += found * found.transpose();
    covariance /= count + priorArcs;
    report(progress, 0.7 + 0.3 * (round + 1) / covarianceRounds);
  }
  learnt.prior = {inverseOf(covariance), learntNoise};
  learnt.coefficients = std::move(fit.coefficients);
  return learnt;
}

}  // namespace sphere_propagation
