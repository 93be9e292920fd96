// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_smoothing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "vcg_ext/base/conjugate_gradients.h"
#include "vcg_ext/base/dense_cholesky.h"
#include "vcg_ext/base/eigen_system.h"
#include "vcg_ext/base/statistics.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/propagation/motion/dense_kernels.h"
#include "vcg_ext/propagation/motion/motion_data.h"
#include "vcg_ext/propagation/motion/motion_uncertainty.h"
#include "vcg_ext/propagation/motion/surface_errors.h"

namespace sphere_propagation {
namespace {

constexpr int columns = MotionBasis::columns;

constexpr double rootTimes = 2;  // the root's errors, over those of another surface
constexpr double firstError = 0.6, firstNoise = 5;
constexpr double errorTimes = 10, errorOfNothing = 0.07, minError = 0.03, maxError = 0.6;
constexpr double minNoise = 1.25, maxNoise = 10, moreResidual = 0.02;
constexpr double stepPower = 0.7;
constexpr double minStep = 0.05;  // of an arc, where the mean is 1
constexpr double steady = 1e-4;   // precision of a surface beside its neighbours': keeps what no
                                  // arc binds
constexpr ConjugateGradientParameters smoothedEnough{1e-5, 200};

/// What a surface says, in sums over its nodes i of w_i a_i b_i^T, where a and b are rows of
///   b  the model's columns, B_i^T m_i
///   q  the root's errors, (m_i . n_i) times its factor's row
///   f  its own errors, in the basis that makes f f diagonal
///   r  the offset of node i
/// with errors of standard deviation 1 edge, lengths in `unit`.
struct LayerSums {
  Eigen::MatrixXf bb, bq, bf, qf;
  Eigen::MatrixXd qq;
  Eigen::VectorXd br, qr, fr, ff;
};

struct SmoothedLayer {
  int layer;
  MotionData data;
  LayerSums sums;
};

/// The sizes of the noises.
struct Noises {
  double white, error;  // kappa; tau
};

LayerSums sumsOf(const MotionModel& model, const MotionData& data,
                 const Eigen::MatrixXd& rootErrors, const Points& rootNormals,
                 const Eigen::MatrixXd& ownErrors, double unit) {
  const Eigen::Index q = rootErrors.cols(), f = ownErrors.cols(), count = data.weights.size();
  RowsF rows(count, columns + q + f + 1);
  rows.leftCols(columns) = model.basis().roughRows(data.directions, data.weights);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double root = std::sqrt(data.weights[i]);
    rows.row(i).segment(columns, q) =
        (root * data.directions.row(i).dot(rootNormals.row(i)) * rootErrors.row(i)).cast<float>();
    rows.row(i).segment(columns + q, f) = (root * ownErrors.row(i)).cast<float>();
    rows(i, columns + q + f) = static_cast<float>(root * data.offsets[i] / unit);
  }
  const Eigen::MatrixXf all = sumOfOuterProducts(rows);
  const EigenSystem own = eigenSystemOf(all.block(columns + q, columns + q, f, f).cast<double>());
  const Eigen::MatrixXf turn = own.vectors.cast<float>();
  LayerSums sums;
  sums.bb = all.topLeftCorner(columns, columns);
  sums.bq = all.block(0, columns, columns, q);
  sums.qq = all.block(columns, columns, q, q).cast<double>();
  const Eigen::MatrixXf withOwn = Eigen::MatrixXf(all.block(0, columns + q, columns + q, f)) * turn;
  sums.bf = withOwn.topRows(columns);
  sums.qf = withOwn.bottomRows(q);
  sums.ff = own.values.cwiseMax(0.0);
  const Eigen::VectorXf offsets = all.rightCols<1>();
  sums.br = offsets.head(columns).cast<double>();
  sums.qr = offsets.segment(columns, q).cast<double>();
  sums.fr = (turn.transpose() * offsets.segment(columns + q, f)).cast<double>();
  return sums;
}

/// Q of the arcs: the sum of (z_t - z_s)^2 / a_st is z^T Q z. place: of each surface among the
/// rows, -1 for the root.
Eigen::MatrixXd precisionInTime(const std::vector<Arc>& arcs, const Eigen::VectorXd& steps,
                                const std::vector<int>& place, int layers) {
  Eigen::MatrixXd q = steady * Eigen::MatrixXd::Identity(layers, layers);
  for (size_t k = 0; k < arcs.size(); ++k) {
    const int s = place[static_cast<size_t>(arcs[k].from)],
              t = place[static_cast<size_t>(arcs[k].to)];
    const double precision = 1 / steps[static_cast<Eigen::Index>(k)];
    if (s >= 0) q(s, s) += precision;
    if (t >= 0) q(t, t) += precision;
    if (s < 0 || t < 0) continue;
    q(s, t) -= precision;
    q(t, s) -= precision;
  }
  return q;
}

/// Calls f(begin, count) for a few columns at a time, as many whatever the number of threads, so
/// that products round alike.
template <class Function>
void byColumns(Eigen::Index columns, ThreadPool& pool, const Function& f) {
  constexpr Eigen::Index atOnce = 8;
  pool.forEach(static_cast<int>((columns + atOnce - 1) / atOnce),
               [&](int k) { f(k * atOnce, std::min(atOnce, columns - k * atOnce)); });
}

/// (the mean of the surfaces' H + mu Sigma^-1)^-1 in the eigenvectors mu of time: what conjugate
/// gradients are preconditioned with.
class Preconditioner {
 public:
  Preconditioner(const Eigen::MatrixXd& meanOfData, const MotionPrior& prior,
                 const Eigen::MatrixXd& inTime)
      : time_(eigenSystemOf(inTime)) {
    const DenseCholesky factor(prior.precision);
    const Eigen::MatrixXd whitened = factor.solveLower(factor.solveLower(meanOfData).transpose());
    const EigenSystem data = eigenSystemOf(whitened);
    data_ = data.values.cwiseMax(1e-6);
    basis_ = factor.solveUpper(data.vectors);
  }
  /// times: what the data count now, over when it was made.
  Eigen::MatrixXd applied(const Eigen::MatrixXd& x, double times, ThreadPool& pool) const {
    Eigen::MatrixXd inner = x * time_.vectors;
    byColumns(inner.cols(), pool, [&](Eigen::Index begin, Eigen::Index count) {
      Eigen::MatrixXd some = basis_.transpose() * inner.middleCols(begin, count);
      for (Eigen::Index t = 0; t < count; ++t)
        some.col(t).array() /= times * data_.array() + time_.values[begin + t];
      inner.middleCols(begin, count).noalias() = basis_ * some;
    });
    return inner * time_.vectors.transpose();
  }

 private:
  EigenSystem time_;
  Eigen::VectorXd data_;
  Eigen::MatrixXd basis_;
};

struct SmoothingProblem {
  const MotionModel& model;
  const MotionPrior& prior;
  std::vector<SmoothedLayer> layers;
  Eigen::MatrixXd rootErrors;  // #N by q, for a standard deviation of 1 edge
  Points rootNormals;
  Eigen::MatrixXd inTime;  // Q
  Eigen::MatrixXd start;   // z where it is linearised, columns by surfaces
  double unit;             // of length
  ThreadPool& pool;
  int count() const { return static_cast<int>(layers.size()); }
};

/// Changes of the coefficients, columns by surfaces, and e's coefficients; in `unit`.
struct Solution {
  Eigen::MatrixXd change;
  Eigen::VectorXd root;
};

/// Own errors integrated out, what a surface says of (b, q) is sums - f diag(shares) f^T, over
/// kappa.
Eigen::VectorXd sharesOf(const LayerSums& sums, const Noises& noises) {
  const double variance = noises.error * noises.error;
  return variance / (noises.white + variance * sums.ff.array());
}

/// What a surface says of the coefficients, times kappa.
Eigen::MatrixXf informationFrom(const LayerSums& sums, const Noises& noises) {
  const Eigen::VectorXf roots = sharesOf(sums, noises).cwiseSqrt().cast<float>();
  const RowsF own = (sums.bf * roots.asDiagonal()).transpose();
  return sums.bb - sumOfOuterProducts(own);
}

/// The mean over surfaces of what they say of the coefficients.
Eigen::MatrixXd meanInformation(const SmoothingProblem& problem, const Noises& noises) {
  const std::vector<Eigen::MatrixXf> each = problem.pool.makeEach(problem.count(), [&](int t) {
    return informationFrom(problem.layers[static_cast<size_t>(t)].sums, noises);
  });
  Eigen::MatrixXf sum = Eigen::MatrixXf::Zero(columns, columns);
  for (const Eigen::MatrixXf& one : each) sum += one;
  return sum.cast<double>() / (noises.white * problem.count());
}

class SmoothingSystem {
 public:
  SmoothingSystem(const SmoothingProblem& problem, const Noises& noises)
      : problem_(problem), noises_(noises), rootSize_(rootTimes * noises.error) {
    const Eigen::Index q = problem.rootErrors.cols();
    const auto count = static_cast<size_t>(problem.count());
    shares_.resize(count);
    coupling_.resize(count);
    right_.resize(columns, problem.count());
    std::vector<Eigen::MatrixXd> rootMatrix(count);
    std::vector<Eigen::VectorXd> rootRight(count);
    problem.pool.forEach(problem.count(), [&](int t) {
      const auto k = static_cast<size_t>(t);
      const LayerSums& s = problem.layers[k].sums;
      const Eigen::VectorXd shares = sharesOf(s, noises);
      shares_[k] = shares.cast<float>();
      const Eigen::MatrixXf qf = s.qf * shares_[k].asDiagonal();
      const auto scale = static_cast<float>(rootSize_ / noises.white);
      coupling_[k] = s.bq;
      coupling_[k] -= s.bf * qf.transpose();
      coupling_[k] *= scale;
      const Eigen::VectorXd own = shares.cwiseProduct(s.fr);
      right_.col(t) = (s.br - s.bf.cast<double>() * own) / noises.white;
      rootMatrix[k] =
          rootSize_ * rootSize_ / noises.white * (s.qq - (qf * s.qf.transpose()).cast<double>());
      rootRight[k] = rootSize_ / noises.white * (s.qr - s.qf.cast<double>() * own);
    });
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(q, q);
    rootRight_ = Eigen::VectorXd::Zero(q);
    for (size_t k = 0; k < count; ++k) {
      matrix += rootMatrix[k];
      rootRight_ += rootRight[k];
    }
    rootMatrix_ = matrix;
    rootFactor_ = DenseCholesky(std::move(matrix));
    const Eigen::MatrixXd start = problem.start / problem.unit;
    right_ -= boundBy(start);
    const Eigen::VectorXf share = rootFactor_.solve(rootRight_).cast<float>();
    for (size_t k = 0; k < count; ++k)
      right_.col(static_cast<Eigen::Index>(k)) -= (coupling_[k] * share).cast<double>();
  }

  /// The root's errors integrated out as well.
  Eigen::MatrixXd times(const Eigen::MatrixXd& x) const {
    Eigen::MatrixXd y = boundBy(x);
    const auto scale = static_cast<float>(1 / noises_.white);
    Eigen::MatrixXd ofRoot(problem_.rootErrors.cols(), problem_.count());
    problem_.pool.forEach(problem_.count(), [&](int t) {
      const auto k = static_cast<size_t>(t);
      const LayerSums& s = problem_.layers[k].sums;
      const Eigen::VectorXf there = x.col(t).cast<float>();
      const Eigen::VectorXf own = shares_[k].cwiseProduct(s.bf.transpose() * there);
      y.col(t) += (scale * (s.bb * there - s.bf * own)).cast<double>();
      ofRoot.col(t) = (coupling_[k].transpose() * there).cast<double>();
    });
    const Eigen::VectorXf share =
        rootFactor_.solve(Eigen::VectorXd(ofRoot.rowwise().sum())).cast<float>();
    problem_.pool.forEach(problem_.count(), [&](int t) {
      y.col(t) -= (coupling_[static_cast<size_t>(t)] * share).cast<double>();
    });
    return y;
  }

  /// x: a change that is near.
  Solution solve(const Preconditioner& preconditioner, Eigen::MatrixXd x) const {
    const auto like = [&](const Eigen::MatrixXd& y) {
      return preconditioner.applied(y, firstNoise / noises_.white, problem_.pool);
    };
    solveByConjugateGradients([&](const Eigen::MatrixXd& y) { return times(y); }, like, right_, x,
                              smoothedEnough);
    Eigen::VectorXd right = rootRight_;
    for (int t = 0; t < problem_.count(); ++t)
      right -=
          (coupling_[static_cast<size_t>(t)].transpose() * x.col(t).cast<float>()).cast<double>();
    return {std::move(x), rootFactor_.solve(right)};
  }

  /// Of each surface's coefficients, e integrated out.
  std::vector<Eigen::MatrixXd> covariances() const {
    const DenseCholesky whitening(problem_.prior.precision);
    const auto count = static_cast<size_t>(problem_.count());
    BoundChain chain{std::vector<Eigen::MatrixXd>(count), problem_.inTime,
                     std::vector<Eigen::MatrixXd>(count), rootMatrix_};
    problem_.pool.forEach(problem_.count(), [&](int t) {
      const auto k = static_cast<size_t>(t);
      const Eigen::MatrixXd information =
          informationFrom(problem_.layers[k].sums, noises_).cast<double>() / noises_.white;
      const Eigen::MatrixXd half = whitening.solveLower(information);
      chain.blocks[k] = whitening.solveLower(half.transpose());
      chain.coupling[k] = whitening.solveLower(coupling_[k].cast<double>());
    });
    std::vector<Eigen::MatrixXd> covariances = covariancesOf(chain, problem_.pool);
    problem_.pool.forEach(problem_.count(), [&](int t) {
      Eigen::MatrixXd& covariance = covariances[static_cast<size_t>(t)];
      const Eigen::MatrixXd half = whitening.solveUpper(covariance);
      covariance = whitening.solveUpper(half.transpose());
    });
    return covariances;
  }

 private:
  /// What the prior and the arcs say of x.
  Eigen::MatrixXd boundBy(const Eigen::MatrixXd& x) const {
    Eigen::MatrixXd bound = x * problem_.inTime;
    byColumns(bound.cols(), problem_.pool, [&](Eigen::Index begin, Eigen::Index count) {
      const Eigen::MatrixXd some = problem_.prior.precision * bound.middleCols(begin, count);
      bound.middleCols(begin, count) = some;
    });
    return bound;
  }

  const SmoothingProblem& problem_;
  Noises noises_;
  double rootSize_;
  std::vector<Eigen::VectorXf> shares_;
  std::vector<Eigen::MatrixXf> coupling_;
  Eigen::MatrixXd right_;
  Eigen::VectorXd rootRight_;
  Eigen::MatrixXd rootMatrix_;
  DenseCholesky rootFactor_;
};

/// The mean over surfaces of the median distance of the nodes from each, in `unit`.
double medianDistanceOf(const SmoothingProblem& problem, const Solution& solution, double error) {
  const Eigen::VectorXd root = rootTimes * error * (problem.rootErrors * solution.root);
  std::vector<double> medians(problem.layers.size());
  problem.pool.forEach(problem.count(), [&](int t) {
    const MotionData& data = problem.layers[static_cast<size_t>(t)].data;
    const Points moved = problem.model.basis().roughDisplacements(solution.change.col(t));
    std::vector<double> distances;
    for (Eigen::Index i = 0; i < data.weights.size(); ++i) {
      if (!(data.weights[i] > 0)) continue;
      const double explained =
          data.directions.row(i).dot(moved.row(i) + root[i] * problem.rootNormals.row(i));
      distances.push_back(std::fabs(data.offsets[i] / problem.unit - explained));
    }
    medians[static_cast<size_t>(t)] = medianOf(std::move(distances));
  });
  double sum = 0;
  for (double median : medians) sum += median;
  return sum / static_cast<double>(medians.size());
}

/// d of the header: in standard deviations.
double offsetOfFlattest(const SmoothingProblem& problem, const Solution& solution,
                        const Noises& noises, double deviation) {
  double sum = 0;
  for (int t = 0; t < problem.count(); ++t) {
    const LayerSums& s = problem.layers[static_cast<size_t>(t)].sums;
    const Eigen::Index flattest = s.ff.size() - 1;
    const double left =
        s.fr[flattest] - s.bf.col(flattest).cast<double>().dot(solution.change.col(t)) -
        rootTimes * noises.error * s.qf.col(flattest).cast<double>().dot(solution.root);
    const double found = noises.error * left /
                         (noises.white + noises.error * noises.error * s.ff[flattest]) / deviation;
    sum += found * found;
  }
  return noises.error * std::sqrt(sum / problem.count());
}

/// a_st of the header, one entry per arc.
Eigen::VectorXd stepsOf(const SmoothingProblem& problem, const std::vector<Arc>& arcs,
                        const std::vector<int>& place) {
  const auto along = [&](int t, Eigen::Index i) {  // how far node i has come along the normal
    if (t < 0) return 0.0;
    const MotionData& data = problem.layers[static_cast<size_t>(t)].data;
    return data.directions.row(i).dot(data.nodes.row(i) - problem.model.nodes().row(i)) +
           data.offsets[i];
  };
  const auto seen = [&](int t, Eigen::Index i) {
    return t < 0 || problem.layers[static_cast<size_t>(t)].data.weights[i] > 0;
  };
  Eigen::VectorXd steps(static_cast<Eigen::Index>(arcs.size()));
  for (size_t k = 0; k < arcs.size(); ++k) {
    const int s = place[static_cast<size_t>(arcs[k].from)],
              t = place[static_cast<size_t>(arcs[k].to)];
    std::vector<double> squares;
    for (Eigen::Index i = 0; i < problem.model.nodes().rows(); ++i) {
      if (!seen(s, i) || !seen(t, i)) continue;
      const double step = (along(t, i) - along(s, i)) / problem.unit;
      squares.push_back(step * step);
    }
    steps[static_cast<Eigen::Index>(k)] = medianOf(std::move(squares));
  }
  if (!(steps.mean() > 0)) return Eigen::VectorXd::Ones(steps.size());
  steps = steps.array().pow(stepPower).matrix();
  steps = (steps / steps.mean()).cwiseMax(minStep);
  return steps / steps.mean();
}

}  // namespace

MotionPrior priorForAllAtOnce(const MotionPrior& learnt) {
  return learnt.withVariancesTimes({0.45, 0.7, 6, 1});
}

SmoothedMotion smoothMotion(const MotionModel& model, const Sequence& sequence, int root,
                            const std::vector<Arc>& arcs, const std::vector<Eigen::VectorXd>& start,
                            const MotionPrior& prior, ThreadPool& pool, bool withCovariances) {
  SmoothedMotion smoothed;
  smoothed.coefficients = start;
  // Errors count in units of sqrt(A0/2), as coefficients do.
  const double deviation = std::sqrt(0.5 * model.meanVertexArea());
  SmoothingProblem problem{model,
                           prior,
                           {},
                           {},
                           vertexNormals(model.nodes(), model.faces()),
                           {},
                           {},
                           sequence[root].meanEdge(),
                           pool};
  problem.rootErrors =
      surfaceErrorFactor(model.nodes(), problem.rootNormals, sequence[root].meanEdge()) *
      (sequence[root].meanEdge() / deviation);
  std::vector<int> place(start.size(), -1), layers;
  for (const Arc& arc : arcs)
    for (int end : {arc.from, arc.to})
      if (end != root && std::find(layers.begin(), layers.end(), end) == layers.end())
        layers.push_back(end);
  if (layers.empty()) return smoothed;
  std::sort(layers.begin(), layers.end());
  for (size_t k = 0; k < layers.size(); ++k)
    place[static_cast<size_t>(layers[k])] = static_cast<int>(k);
  problem.start.resize(columns, static_cast<Eigen::Index>(layers.size()));
  problem.layers = pool.makeEach(static_cast<int>(layers.size()), [&](int k) {
    const int t = layers[static_cast<size_t>(k)];
    const Eigen::VectorXd& c = start[static_cast<size_t>(t)];
    problem.start.col(k) = c;
    std::vector<int> nearby(static_cast<size_t>(model.nodes().rows()), -1);
    MotionData data = motionDataAt(model, sequence[t], c, nearby);
    const double edge = sequence[t].meanEdge();
    const Eigen::MatrixXd own =
        surfaceErrorFactor(data.nodes, data.directions, edge) * (edge / deviation);
    LayerSums sums =
        sumsOf(model, data, problem.rootErrors, problem.rootNormals, own, problem.unit);
    return SmoothedLayer{t, std::move(data), std::move(sums)};
  });
  problem.inTime = precisionInTime(arcs, stepsOf(problem, arcs, place), place, problem.count());

  Noises noises{firstNoise, firstError};
  const Preconditioner preconditioner(meanInformation(problem, noises), prior, problem.inTime);
  Solution solution = SmoothingSystem(problem, noises)
                          .solve(preconditioner, Eigen::MatrixXd::Zero(columns, problem.count()));
  const double offset = offsetOfFlattest(problem, solution, noises, deviation / problem.unit);
  noises.error = std::clamp(errorTimes * (offset - errorOfNothing), minError, maxError);
  Solution best;
  double least = std::numeric_limits<double>::infinity();
  for (noises.white = minNoise; noises.white < 1.01 * maxNoise; noises.white *= std::sqrt(2.0)) {
    solution = SmoothingSystem(problem, noises).solve(preconditioner, solution.change);
    const double residual = medianDistanceOf(problem, solution, noises.error);
    least = std::min(least, residual);
    if (!(residual <= (1 + moreResidual) * least)) break;
    best = solution;
    smoothed.noise = noises.white;
  }
  if (best.change.size() == 0 || !best.change.allFinite()) return smoothed;
  smoothed.errorInEdges = noises.error;
  smoothed.rootError = problem.unit * rootTimes * noises.error * (problem.rootErrors * best.root);
  for (int k = 0; k < problem.count(); ++k)
    smoothed.coefficients[static_cast<size_t>(problem.layers[static_cast<size_t>(k)].layer)] +=
        problem.unit * best.change.col(k);
  if (!withCovariances) return smoothed;
  noises.white = smoothed.noise;
  std::vector<Eigen::MatrixXd> covariances = SmoothingSystem(problem, noises).covariances();
  smoothed.covariances.resize(start.size());
  for (size_t k = 0; k < covariances.size(); ++k)
    smoothed.covariances[static_cast<size_t>(problem.layers[k].layer)] = std::move(covariances[k]);
  return smoothed;
}

}  // namespace sphere_propagation
