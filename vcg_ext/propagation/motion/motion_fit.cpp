// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "vcg_ext/base/dense_kernels.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

constexpr double agreement = 0.5;  // least dot product of a layer's face normal with the template's
constexpr int local = MotionModel::localColumns, affine = MotionModel::affineColumns,
              all = MotionModel::columns;

// Learning, all variances in units of A0/2.
constexpr MotionVariances fixedVariances{1, 0.5, 1, 0.3}, wideVariances{1, 2, 1, 0.5},
    startVariances{0.15, 0.5, 0.5, 0.2};
constexpr double wideNoise = 6, temperedNoise = 12, learntNoise = 2.5;
constexpr int coarse = 3000;  // vertices
constexpr double varianceFloor = 0.015;
constexpr int varianceRounds = 100, covarianceRounds = 12;
constexpr double solved = 1e-6;      // squared, in the norm that conjugate gradients make smaller
constexpr double strainShare = 0.1;  // the evidence over-estimates strain
constexpr double priorArcs = 16;     // what the diagonal covariance counts against the arcs

double medianOf(std::vector<double> values) {
  if (values.empty()) return 0;
  const size_t half = values.size() / 2;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(half),
                   values.end());
  const double upper = values[half];
  if (values.size() % 2 == 1) return upper;
  return 0.5 * (upper + *std::max_element(values.begin(),
                                          values.begin() + static_cast<std::ptrdiff_t>(half)));
}

/// How many vertices a layer's noise is taken for. That of few is partly theirs, as that of large
/// voxels, and partly of the shape, which is as smooth on a coarse mesh as on a fine one: the
/// geometric mean with `coarse` stands between.
double countedVertices(int count) {
  return count < coarse ? std::sqrt(static_cast<double>(count) * coarse) : count;
}

/// The data term at c, for noise 1.
struct DataTerm {
  Eigen::VectorXd weights;  // of the nodes; zero where no face of the layer agrees
  Points directions;        // m_i
  Points pull;              // w_i (m_i . (p_i - x_i)) m_i
  double distance;          // mean, of the nodes with which a face agrees
};

/// nearby: for each node a face of the layer to look at first, -1 where there is none; the closest
/// ones on return.
DataTerm dataTermAt(const MotionModel& model, const MotionTarget& target, const Eigen::VectorXd& c,
                    std::vector<int>& nearby) {
  const Points moved = model.movedNodes(c, MotionModel::Precision::Single),
               normals = vertexNormals(moved, model.faces());
  const Eigen::Index count = moved.rows();
  std::vector<SurfacePoint> closest(static_cast<size_t>(count));
  std::vector<double> distances;
  distances.reserve(closest.size());
  int last = -1;  // nodes that follow each other are often neighbours
  for (Eigen::Index i = 0; i < count; ++i) {
    SurfacePoint& point = closest[static_cast<size_t>(i)];
    int& near = nearby[static_cast<size_t>(i)];
    point = target.locator->closest(moved.row(i).transpose(), normals.row(i).transpose(), agreement,
                                    near >= 0 ? near : last);
    near = last = point.face;
    if (point.face >= 0) distances.push_back(point.distance);
  }
  const double scale = std::max(4 * medianOf(distances), target.meanEdge);
  const double unit =
      0.5 * model.meanVertexArea() / (target.meanVertexArea * target.meanVertexArea);
  const double mean = std::accumulate(distances.begin(), distances.end(), 0.0) /
                      static_cast<double>(distances.size());
  DataTerm data{Eigen::VectorXd::Zero(count), Points::Zero(count, 3), Points::Zero(count, 3), mean};
  for (Eigen::Index i = 0; i < count; ++i) {
    const SurfacePoint& point = closest[static_cast<size_t>(i)];
    if (point.face < 0) continue;
    const Vector3 m = point.interpolate(target.surface->faces(), target.normals).normalized();
    const Vector3 p = point.interpolate(target.surface->faces(), target.surface->vertices());
    const double robust = 1 / (1 + (point.distance / scale) * (point.distance / scale));
    data.weights[i] = unit * model.areas()[i] * robust;
    data.directions.row(i) = m.transpose();
    data.pull.row(i) = data.weights[i] * m.dot(p - moved.row(i).transpose()) * m.transpose();
  }
  return data;
}

/// What the data term says of each coefficient: the sum of w_i (B_i^T m_i) (B_i^T m_i)^T.
Eigen::MatrixXd informationOf(const MotionModel& model, const DataTerm& data) {
  // In single precision: it says how far to step, not where to, and costs half.
  return sumOfOuterProducts(model.projectEach(data.directions, data.weights.cwiseSqrt()))
      .cast<double>();
}

/// The gradient of the data term, for noise 1.
Eigen::VectorXd pullOf(const MotionModel& model, const DataTerm& data) {
  return model.projectAll(data.pull, MotionModel::Precision::Single);
}

/// Fits layer after layer. fitOne(fit so far, s, t): the arc from layer s to layer t.
template <class Function>
MotionFit overTree(const std::vector<MotionTarget>& targets, const PropagationTree& tree,
                   ThreadPool& pool, const Progress& progress, const Function& fitOne) {
  MotionFit fit;
  fit.coefficients.assign(targets.size(), Eigen::VectorXd::Zero(all));
  fit.equations.resize(targets.size());
  fit.factors.resize(targets.size());
  fit.lost.assign(targets.size(), 0);
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
      fit.lost[t] = arc.distance <= maxDistanceInEdges * targets[t].meanEdge ? 0 : 1;
    });
    done += levels[level].size();
    report(progress, static_cast<double>(done) / static_cast<double>(targets.size()));
  }
  return fit;
}

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
  const Eigen::MatrixXd solved = inner.llt().solve(right);
  const Eigen::MatrixXd mixed = e.matrix.bottomLeftCorner(affine, local);
  return {e.matrix.bottomRightCorner(affine, affine) - mixed * solved.leftCols(affine),
          e.vector.tail(affine) - mixed * solved.col(affine)};
}

/// Solves (H + precision) c = h by conjugate gradients, from the c that is given. inverse: that of
/// a similar matrix.
void solve(const ArcEquations& e, const Eigen::MatrixXd& precision, const Eigen::MatrixXd& inverse,
           Eigen::VectorXd& c) {
  const Eigen::MatrixXd system = e.matrix + precision;
  Eigen::VectorXd rest = e.vector - system * c, step = inverse * rest, along = step;
  double left = rest.dot(step);
  const double enough = solved * e.vector.dot(inverse * e.vector);
  for (int i = 0; i < all && left > enough; ++i) {
    const Eigen::VectorXd image = system * along;
    const double length = left / along.dot(image);
    c += length * along;
    rest -= length * image;
    step.noalias() = inverse * rest;
    const double before = std::exchange(left, rest.dot(step));
    along = step + left / before * along;
  }
}

MotionVariances learnVariances(const std::vector<ArcEquations>& equations) {
  std::vector<AffineSystem> systems;
  systems.reserve(equations.size());
  for (const ArcEquations& e : equations) systems.push_back(withoutLocal(e, startVariances.local));
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

Eigen::VectorXd MotionVariances::diagonal() const {
  Eigen::VectorXd d(all);
  d << Eigen::VectorXd::Constant(MotionModel::localColumns, local),
      Eigen::VectorXd::Constant(MotionModel::translationColumns, translation),
      Eigen::VectorXd::Constant(MotionModel::strainColumns, strain),
      Eigen::VectorXd::Constant(MotionModel::rotationColumns, rotation);
  return d;
}

MotionPrior fixedMotionPrior() {
  return {fixedVariances.diagonal().cwiseInverse().asDiagonal(), wideNoise};
}

MotionTarget::MotionTarget(const ClosedSurface& layer,
                           std::shared_ptr<const SurfaceLocator> locatorOfLayer)
    : surface(&layer),
      locator(locatorOfLayer
                  ? std::move(locatorOfLayer)
                  : std::make_shared<const SurfaceLocator>(layer.vertices(), layer.faces())),
      normals(vertexNormals(layer.vertices(), layer.faces())),
      meanVertexArea(faceAreas(layer.vertices(), layer.faces()).sum() /
                     countedVertices(layer.vertexCount())),
      meanEdge(meanEdgeLength(layer.vertices(), layer.faces())) {}

std::vector<MotionTarget> motionTargets(const std::vector<ClosedSurface>& surfaces,
                                        ThreadPool& pool, const LayerLocators& locators) {
  return pool.makeEach(static_cast<int>(surfaces.size()), [&](int k) {
    const auto i = static_cast<size_t>(k);
    return MotionTarget(surfaces[i], locators.empty() ? nullptr : locators[i]);
  });
}

ArcFit fitArc(const MotionModel& model, const MotionTarget& target, const Eigen::VectorXd& before,
              const MotionPrior& prior, const Eigen::VectorXd& start, int iterations) {
  ArcFit fit{before, {}, {}, 0};
  if (start.size() > 0) fit.coefficients += start;
  std::vector<int> nearby(static_cast<size_t>(model.nodes().rows()), -1);
  ArcEquations& e = fit.equations;
  for (int i = 0; i < iterations; ++i) {
    const DataTerm data = dataTermAt(model, target, fit.coefficients, nearby);
    if (i == 0 || start.size() == 0) {
      e.matrix = informationOf(model, data) / prior.noise;
      fit.factor.compute(e.matrix + prior.precision);
    }
    e.vector = pullOf(model, data) / prior.noise + e.matrix * (fit.coefficients - before);
    fit.coefficients = before + fit.factor.solve(e.vector);
    fit.distance = data.distance;
  }
  return fit;
}

Eigen::VectorXd fitArcAgain(const MotionModel& model, const MotionTarget& target,
                            const Eigen::VectorXd& before, const MotionPrior& prior,
                            const Eigen::VectorXd& start, const ArcSystem& system) {
  std::vector<int> nearby(static_cast<size_t>(model.nodes().rows()), -1);
  const DataTerm data = dataTermAt(model, target, before + start, nearby);
  return before + system.factor.solve(pullOf(model, data) / prior.noise + system.matrix * start);
}

MotionFit fitMotion(const MotionModel& model, const std::vector<MotionTarget>& targets,
                    const PropagationTree& tree, const MotionPrior& prior, ThreadPool& pool,
                    const Progress& progress) {
  return overTree(targets, tree, pool, progress, [&](const MotionFit& fit, size_t s, size_t t) {
    return fitArc(model, targets[t], fit.coefficients[s], prior, {}, arcIterations);
  });
}

MotionFit refitMotion(const MotionModel& model, const std::vector<MotionTarget>& targets,
                      const PropagationTree& tree, const MotionPrior& prior,
                      const std::vector<Eigen::VectorXd>& earlier, ThreadPool& pool,
                      const Progress& progress) {
  return overTree(targets, tree, pool, progress, [&](const MotionFit& fit, size_t s, size_t t) {
    return fitArc(model, targets[t], fit.coefficients[s], prior, earlier[t] - earlier[s],
                  arcIterationsAgain);
  });
}

LearntPrior learnMotionPrior(const MotionModel& model, const std::vector<MotionTarget>& targets,
                             const PropagationTree& tree, ThreadPool& pool,
                             const Progress& progress) {
  const MotionPrior wide{wideVariances.diagonal().cwiseInverse().asDiagonal(), wideNoise};
  LearntPrior learnt;
  MotionFit fit = fitMotion(model, targets, tree, wide, pool, part(progress, 0, 0.7));
  std::vector<ArcEquations> equations;
  const double temper = wideNoise / temperedNoise, unit = std::sqrt(0.5 * model.meanVertexArea());
  for (const bool lostToo :
       {false, true}) {  // what is lost teaches nothing, unless there is nothing else
    for (size_t t = 0; t < targets.size(); ++t) {
      const ArcEquations& e = fit.equations[t];
      if (e.vector.size() > 0 && (lostToo || !fit.lost[t]))
        equations.push_back({temper * e.matrix, temper / unit * e.vector});
    }
    if (!equations.empty()) break;
  }
  learnt.variances = learnVariances(equations);
  const Eigen::MatrixXd towards = learnt.variances.diagonal().asDiagonal();
  const double count = static_cast<double>(equations.size());
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(all, all), covariance = towards;
  for (const ArcEquations& e : equations) mean += e.matrix / count;
  std::vector<Eigen::VectorXd> expected(equations.size(), Eigen::VectorXd::Zero(all));
  for (int round = 0; round < covarianceRounds; ++round) {
    const Eigen::MatrixXd precision = inverseOf(covariance),
                          uncertainty = inverseOf(mean + precision);
    pool.forEach(static_cast<int>(equations.size()), [&](int k) {
      const auto i = static_cast<size_t>(k);
      solve(equations[i], precision, uncertainty, expected[i]);
    });
    covariance = priorArcs * towards + count * uncertainty;
    for (const Eigen::VectorXd& c : expected) covariance.noalias() += c * c.transpose();
    covariance /= count + priorArcs;
    report(progress, 0.7 + 0.3 * (round + 1) / covarianceRounds);
  }
  learnt.prior = {inverseOf(covariance), learntNoise};
  learnt.coefficients = std::move(fit.coefficients);
  return learnt;
}

}  // namespace sphere_propagation
