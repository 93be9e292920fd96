// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "vcg_ext/base/statistics.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

constexpr double minAgreement =
    0.5;                      // least dot product of a layer's face normal with the template's
constexpr int coarse = 3000;  // vertices

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
DataTerm dataTermAt(const MotionModel& model, const PreparedSurface& target,
                    const Eigen::VectorXd& c, std::vector<int>& nearby) {
  const Points moved = model.roughMovedNodes(c), normals = vertexNormals(moved, model.faces());
  const Eigen::Index count = moved.rows();
  std::vector<SurfacePoint> closest(static_cast<size_t>(count));
  std::vector<double> distances;
  distances.reserve(closest.size());
  const SurfaceLocator& locator = target.locator();
  int last = -1;  // nodes that follow each other are often neighbours
  for (Eigen::Index i = 0; i < count; ++i) {
    SurfacePoint& point = closest[static_cast<size_t>(i)];
    int& near = nearby[static_cast<size_t>(i)];
    point = locator.closest(moved.row(i).transpose(), normals.row(i).transpose(), minAgreement,
                            near >= 0 ? near : last);
    near = last = point.face;
    if (point.face >= 0) distances.push_back(point.distance);
  }
  const double vertexArea = target.area() / countedVertices(target.surface().vertexCount());
  const double scale = std::max(4 * medianOf(distances), target.meanEdge());
  const double unit = 0.5 * model.meanVertexArea() / (vertexArea * vertexArea);
  const double mean = std::accumulate(distances.begin(), distances.end(), 0.0) /
                      static_cast<double>(distances.size());
  DataTerm data{Eigen::VectorXd::Zero(count), Points::Zero(count, 3), Points::Zero(count, 3), mean};
  for (Eigen::Index i = 0; i < count; ++i) {
    const SurfacePoint& point = closest[static_cast<size_t>(i)];
    if (point.face < 0) continue;
    const Vector3 m = point.interpolate(target.surface().faces(), target.normals()).normalized();
    const Vector3 p = point.interpolate(target.surface().faces(), target.surface().vertices());
    const double robust = 1 / (1 + (point.distance / scale) * (point.distance / scale));
    data.weights[i] = unit * model.areas()[i] * robust;
    data.directions.row(i) = m.transpose();
    data.pull.row(i) = data.weights[i] * m.dot(p - moved.row(i).transpose()) * m.transpose();
  }
  return data;
}

/// What the data term says of each coefficient: the sum of w_i (B_i^T m_i) (B_i^T m_i)^T. Rough,
/// since it says how far to step, not where to.
Eigen::MatrixXd informationOf(const MotionModel& model, const DataTerm& data) {
  return model.basis().roughInformation(data.directions, data.weights);
}

/// The gradient of the data term, for noise 1.
Eigen::VectorXd pullOf(const MotionModel& model, const DataTerm& data) {
  return model.basis().roughProjectAll(data.pull);
}

/// Fits layer after layer. fitOne(fit so far, s, t): the arc from layer s to layer t.
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

}  // namespace

ArcFit fitArc(const MotionModel& model, const PreparedSurface& target,
              const Eigen::VectorXd& before, const MotionPrior& prior, const Eigen::VectorXd& start,
              int iterations) {
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

Eigen::VectorXd fitArcAgain(const MotionModel& model, const PreparedSurface& target,
                            const Eigen::VectorXd& before, const MotionPrior& prior,
                            const Eigen::VectorXd& start, const ArcSystem& system) {
  std::vector<int> nearby(static_cast<size_t>(model.nodes().rows()), -1);
  const DataTerm data = dataTermAt(model, target, before + start, nearby);
  return before + system.factor.solve(pullOf(model, data) / prior.noise + system.matrix * start);
}

MotionFit fitMotion(const MotionModel& model, const Sequence& sequence, const PropagationTree& tree,
                    const MotionPrior& prior, ThreadPool& pool, const Progress& progress) {
  return overTree(sequence, tree, pool, progress, [&](const MotionFit& fit, size_t s, size_t t) {
    return fitArc(model, sequence[static_cast<int>(t)], fit.coefficients[s], prior, {},
                  arcIterations);
  });
}

MotionFit refitMotion(const MotionModel& model, const Sequence& sequence,
                      const PropagationTree& tree, const MotionPrior& prior,
                      const std::vector<Eigen::VectorXd>& earlier, ThreadPool& pool,
                      const Progress& progress) {
  return overTree(sequence, tree, pool, progress, [&](const MotionFit& fit, size_t s, size_t t) {
    return fitArc(model, sequence[static_cast<int>(t)], fit.coefficients[s], prior,
                  earlier[t] - earlier[s], arcIterationsAgain);
  });
}

}  // namespace sphere_propagation
