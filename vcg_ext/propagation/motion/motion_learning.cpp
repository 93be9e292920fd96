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
constexpr double strainShare = 0.1;  // the evidence over-estimates strain
constexpr double priorArcs = 16;     // what the diagonal covariance counts against the arcs

/// (A + D^-1)^-1 a, the affine system of an arc with the local coefficients integrated out.
struct AffineSystem {
  Eigen::Matrix<double, affine, affine> matrix;
  Eigen::Matrix<double, affine, 1> vector;
};

AffineSystem withoutLocal(const ArcEquations& e, double localVariance) {
  Eigen::MatrixXd inner = e.matrix.topLeftCorner(local, local);
  inner.diagonal().array() += 1 / localVariance;
  Eigen::MatrixXd right(local, affine + 1);
  right << e.matrix.topRightCorner(local, affine), e.vector.head(local);
  const Eigen::MatrixXd solved = DenseCholesky(std::move(inner)).solve(std::move(right));
  const Eigen::MatrixXd mixed = e.matrix.bottomLeftCorner(affine, local);
  return {e.matrix.bottomRightCorner(affine, affine) - mixed * solved.leftCols(affine),
          e.vector.tail(affine) - mixed * solved.col(affine)};
}

/// Solves (H + precision) c = h, from the c that is given. inverse: that of a similar matrix.
void solve(const ArcEquations& e, const Eigen::MatrixXd& precision, const Eigen::MatrixXd& inverse,
           Eigen::VectorXd& c) {
  const Eigen::MatrixXd system = e.matrix + precision;
  solveByConjugateGradients([&](const Eigen::VectorXd& x) { return system * x; },
                            [&](const Eigen::VectorXd& rest) { return inverse * rest; }, e.vector,
                            c, solved);
}

MotionVariances learnVariances(const std::vector<ArcEquations>& equations, ThreadPool& pool) {
  const std::vector<AffineSystem> systems = pool.makeEach(
      static_cast<int>(equations.size()),
      [&](int k) { return withoutLocal(equations[static_cast<size_t>(k)], startVariances.local); });
  MotionVariances variances = startVariances;
  for (int round = 0; round < varianceRounds; ++round) {
    const Eigen::VectorXd precision = variances.diagonal().tail(affine).cwiseInverse();
    Eigen::VectorXd second = Eigen::VectorXd::Zero(affine);
    for (const AffineSystem& system : systems) {
      Eigen::Matrix<double, affine, affine> matrix = system.matrix;
      matrix.diagonal() += precision;
      const Eigen::Matrix<double, affine, affine> covariance = matrix.inverse();
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
    if (change < 1e-3) break;
  }
  variances.strain *= strainShare;
  return variances;
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
  learnt.variances = learnVariances(equations, pool);
  const Eigen::MatrixXd towards = learnt.variances.diagonal().asDiagonal();
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
