// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_anchors.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "vcg_ext/base/dense_cholesky.h"
#include "vcg_ext/base/eigen_system.h"
#include "vcg_ext/base/statistics.h"
#include "vcg_ext/propagation/motion/dense_kernels.h"

namespace sphere_propagation {
namespace {

constexpr double medianOfSquares = 0.789;  // of chi squared with three degrees of freedom, over 3
constexpr double mostWidening = 1e6, muchBetter = 20;
constexpr int halvings = 40;

/// log det C(f) + r^T C(f)^-1 r in the axes of the prior's covariance, where it is a sum.
struct Explanation {
  const Eigen::ArrayXd& variances;  ///< of the prior, along its axes
  Eigen::ArrayXd squares;           ///< of r along them
  double noise;                     ///< sd^2

  double at(double f) const {
    const Eigen::ArrayXd all = f * variances + noise;
    return (all.log() + squares / all).sum();
  }
  double slopeAt(double f) const {
    const Eigen::ArrayXd all = f * variances + noise;
    return (variances / all * (1 - squares / all)).sum();
  }
  /// The first minimum from 1 on.
  double widening() const {
    double low = 1;
    if (!(slopeAt(low) < 0)) return 1;
    while (low < mostWidening && slopeAt(2 * low) < 0) low *= 2;
    double high = 2 * low;
    for (int i = 0; i < halvings; ++i) {
      const double middle = std::sqrt(low * high);
      (slopeAt(middle) < 0 ? low : high) = middle;
    }
    return low;
  }
};

/// B at a place of the template: 3 by columns.
Eigen::MatrixXd rowsAt(const MotionModel& model, const SurfacePoint& site) {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(3, MotionBasis::columns);
  Eigen::VectorXd row(MotionBasis::columns);
  for (int corner = 0; corner < 3; ++corner)
    for (int k = 0; k < 3; ++k) {
      model.basis().project(model.faces()(site.face, corner), Vector3::Unit(k), row.data());
      rows.row(k) += site.weights[corner] * row.transpose();
    }
  return rows;
}

/// Columns by rows, each of its own, such that the sum of these entries is least: the Hungarian
/// method, by shortest augmenting paths (R. Jonker, A. Volgenant, 1987).
std::vector<int> cheapestAssignment(const Eigen::MatrixXd& costs) {
  const auto n = static_cast<size_t>(costs.rows());
  const double infinity = std::numeric_limits<double>::infinity();
  std::vector<double> ofRow(n + 1, 0), ofColumn(n + 1, 0);
  std::vector<size_t> rowOf(n + 1, n), before(n + 1, n);  // by column; the last is no column
  for (size_t row = 0; row < n; ++row) {
    rowOf[n] = row;
    size_t column = n;
    std::vector<double> least(n + 1, infinity);
    std::vector<char> used(n + 1, 0);
    do {
      used[column] = 1;
      const size_t i = rowOf[column];
      size_t next = n;
      double step = infinity;
      for (size_t j = 0; j < n; ++j) {
        if (used[j]) continue;
        const double reduced = costs(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) -
                               ofRow[i] - ofColumn[j];
        if (reduced < least[j]) least[j] = reduced, before[j] = column;
        if (next == n || least[j] < step) step = least[j], next = j;
      }
      for (size_t j = 0; j <= n; ++j) {
        if (used[j])
          ofRow[rowOf[j]] += step, ofColumn[j] -= step;
        else
          least[j] -= step;
      }
      column = next;
    } while (rowOf[column] != n);
    for (; column != n; column = before[column]) rowOf[column] = rowOf[before[column]];
  }
  std::vector<int> columns(n, 0);
  for (size_t j = 0; j < n; ++j) columns[rowOf[j]] = static_cast<int>(j);
  return columns;
}

/// The cycles of a permutation, each with its smallest number first.
std::vector<std::vector<int>> turnsOf(const std::vector<int>& permutation) {
  std::vector<std::vector<int>> turns;
  std::vector<char> seen(permutation.size(), 0);
  for (size_t first = 0; first < permutation.size(); ++first) {
    if (seen[first]) continue;
    turns.emplace_back();
    for (size_t k = first; !seen[k]; k = static_cast<size_t>(permutation[k])) {
      seen[k] = 1;
      turns.back().push_back(static_cast<int>(k));
    }
  }
  return turns;
}

}  // namespace

LayerAnchors::LayerAnchors(Eigen::MatrixXd rows, Eigen::VectorXd from, Eigen::VectorXd to,
                           double deviation, double unit)
    : rows_(std::move(rows)),
      from_(std::move(from)),
      to_(std::move(to)),
      weight_(unit / (deviation * deviation)),
      deviation_(deviation),
      unit_(unit) {
  information_ = weight_ * rows_.transpose() * rows_;
}

Eigen::VectorXd LayerAnchors::pull(const Eigen::VectorXd& c) const {
  return weight_ * (rows_.transpose() * residual(c));
}

Eigen::MatrixXd LayerAnchors::priorCovariance(const MotionPrior& prior) const {
  return unit_ * rows_ * DenseCholesky(prior.precision).solve(Eigen::MatrixXd(rows_.transpose()));
}

double LayerAnchors::widening(const Eigen::VectorXd& before, const MotionPrior& prior) const {
  const EigenSystem axes = eigenSystemOf(priorCovariance(prior));
  const Eigen::ArrayXd variances = axes.values.array().max(0);
  const Eigen::VectorXd along = axes.vectors.transpose() * residual(before);
  return Explanation{variances, along.array().square(), deviation_ * deviation_}.widening();
}

std::vector<std::vector<int>> LayerAnchors::exchanged(const Eigen::VectorXd& before,
                                                      const MotionPrior& prior) const {
  const EigenSystem axes = eigenSystemOf(priorCovariance(prior));
  const Eigen::ArrayXd variances = axes.values.array().max(0);
  const Eigen::MatrixXd toAxes = axes.vectors.transpose();
  const Eigen::VectorXd along = toAxes * residual(before);
  const auto best = [&](const Eigen::VectorXd& r) {
    const Explanation explanation{variances, r.array().square(), deviation_ * deviation_};
    return explanation.at(explanation.widening());
  };
  const double asTheyAre = best(along);
  struct Exchange {
    double gain;
    std::vector<int> turn;
  };
  std::vector<Exchange> exchanges;
  const auto add = [&](std::vector<int> turn) {
    Eigen::VectorXd mended = along;
    for (size_t k = 0; k < turn.size(); ++k) {
      // The place of each is what the one before it has.
      const int own = turn[k], from = turn[(k + turn.size() - 1) % turn.size()];
      mended +=
          toAxes.middleCols<3>(3 * own) * (to_.segment<3>(3 * from) - to_.segment<3>(3 * own));
    }
    const double gain = asTheyAre - best(mended);
    if (gain > muchBetter) exchanges.push_back({gain, std::move(turn)});
  };
  const auto count = static_cast<int>(to_.size() / 3);
  for (int i = 0; i < count; ++i)
    for (int j = i + 1; j < count; ++j) add({i, j});
  const Eigen::VectorXd expected = to_ - residual(before);
  Eigen::MatrixXd squares(count, count);
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < count; ++j)
      squares(i, j) = (to_.segment<3>(3 * i) - expected.segment<3>(3 * j)).squaredNorm();
  for (std::vector<int>& turn : turnsOf(cheapestAssignment(squares)))
    if (turn.size() > 2) add(std::move(turn));
  std::stable_sort(exchanges.begin(), exchanges.end(),
                   [](const Exchange& a, const Exchange& b) { return a.gain > b.gain; });
  std::vector<std::vector<int>> found;
  std::vector<char> taken(static_cast<size_t>(count), 0);
  for (Exchange& exchange : exchanges) {
    const auto isTaken = [&](int k) { return taken[static_cast<size_t>(k)] != 0; };
    if (std::any_of(exchange.turn.begin(), exchange.turn.end(), isTaken)) continue;
    for (const int k : exchange.turn) taken[static_cast<size_t>(k)] = 1;
    found.push_back(std::move(exchange.turn));
  }
  return found;
}

Eigen::VectorXd LayerAnchors::step(const Eigen::VectorXd& before, const MotionPrior& prior) const {
  return DenseCholesky(information_ + prior.precision).solve(pull(before));
}

std::vector<double> LayerAnchors::distances(const Eigen::VectorXd& c) const {
  const Eigen::VectorXd r = residual(c);
  std::vector<double> distances;
  for (Eigen::Index k = 0; k < r.size(); k += 3) distances.push_back(r.segment<3>(k).norm());
  return distances;
}

std::vector<double> LayerAnchors::standardised(const Eigen::VectorXd& before,
                                               const MotionPrior& prior) const {
  // The conditional covariance of a block, given the others, is the inverse of its block of the
  // inverse.
  Eigen::MatrixXd covariance = priorCovariance(prior);
  covariance.diagonal().array() += deviation_ * deviation_;
  const Eigen::MatrixXd inverse = inverseOf(covariance);
  const Eigen::VectorXd solved = inverse * residual(before);
  std::vector<double> squares;
  for (Eigen::Index k = 0; k < solved.size(); k += 3) {
    const Vector3 own = solved.segment<3>(k);
    const Eigen::Matrix3d block = inverse.block<3, 3>(k, k);
    squares.push_back(own.dot(block.inverse() * own) / 3);
  }
  const double spread = squares.size() < 2 ? 1 : std::max(1.0, medianOf(squares) / medianOfSquares);
  for (double& square : squares) square = std::sqrt(std::max(0.0, square) / spread);
  return squares;
}

MotionAnchors::MotionAnchors(const MotionModel& model, const Sequence& sequence, int root,
                             const MappedSurface& map, const AnchorPlaces& places,
                             const std::vector<double>& deviations) {
  if (places.empty()) return;
  const auto count = static_cast<size_t>(sequence.size());
  layers_.resize(count);
  const std::vector<SurfacePoint>& ofRoot = places.points[static_cast<size_t>(root)];
  std::vector<Vector3> directions;
  for (const SurfacePoint& point : ofRoot)
    directions.push_back(point.interpolate(map.faces(), map.positions()));
  const std::vector<SurfacePoint> sites = model.sitesOf(directions);
  for (size_t t = 0; t < count; ++t) {
    const std::vector<size_t> there = places.of(t);
    if (static_cast<int>(t) == root || there.empty()) continue;
    const ClosedSurface& surface = sequence.surface(static_cast<int>(t));
    Eigen::MatrixXd rows(3 * there.size(), MotionBasis::columns);
    Eigen::VectorXd from(3 * there.size()), to(3 * there.size());
    for (size_t i = 0; i < there.size(); ++i) {
      const size_t k = there[i];
      const auto row = static_cast<Eigen::Index>(3 * i);
      rows.middleRows<3>(row) = rowsAt(model, sites[k]);
      from.segment<3>(row) = ofRoot[k].interpolate(map.faces(), map.surface().vertices());
      to.segment<3>(row) = places.points[t][k].interpolate(surface.faces(), surface.vertices());
    }
    layers_[t].emplace(std::move(rows), std::move(from), std::move(to), deviations[t],
                       0.5 * model.meanVertexArea());
  }
  if (std::none_of(layers_.begin(), layers_.end(), [](const auto& its) { return its.has_value(); }))
    layers_.clear();
}

}  // namespace sphere_propagation
