#include "vcg_ext/propagation/motion_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

constexpr int iterations = 3;      // per arc
constexpr double agreement = 0.5;  // least dot product of a layer's face normal with the template's
constexpr int local = MotionModel::localColumns, affine = MotionModel::affineColumns, all = MotionModel::columns;

// Learning, all variances in units of A0/2.
constexpr MotionVariances fixedVariances{1, 0.5, 1, 0.3}, wideVariances{1, 2, 1, 0.5},
    startVariances{0.15, 0.5, 0.5, 0.2};
constexpr double wideNoise = 6, temperedNoise = 24, learntNoise = 1.5;
constexpr double varianceFloor = 0.01;
constexpr int varianceRounds = 100, covarianceRounds = 10;
constexpr double strainShare = 0.1;  // the evidence over-estimates strain
constexpr double priorArcs = 8;      // what the diagonal covariance counts against the arcs

double medianOf(std::vector<double> values) {
  if (values.empty()) return 0;
  const size_t half = values.size() / 2;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(half), values.end());
  const double upper = values[half];
  if (values.size() % 2 == 1) return upper;
  return 0.5 * (upper + *std::max_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(half)));
}

/// The data term at c, linear in the step away from `before`.
ArcEquations equationsAt(const MotionModel& model, const MotionTarget& target, const Eigen::VectorXd& c,
                         const Eigen::VectorXd& before, double noise) {
  const Points moved = model.movedNodes(c), normals = vertexNormals(moved, model.faces());
  const Eigen::Index count = moved.rows();
  std::vector<SurfacePoint> closest(static_cast<size_t>(count));
  std::vector<double> distances;
  for (Eigen::Index i = 0; i < count; ++i) {
    SurfacePoint& point = closest[static_cast<size_t>(i)];
    point = target.locator.closest(moved.row(i).transpose(), normals.row(i).transpose(), agreement);
    if (point.face >= 0) distances.push_back(point.distance);
  }
  const double scale = std::max(4 * medianOf(distances), target.meanEdge);
  Eigen::MatrixXd rows(all, static_cast<Eigen::Index>(distances.size()));  // column i: sqrt(weight) b_i
  Eigen::VectorXd rightSides(rows.cols());
  Eigen::Index used = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const SurfacePoint& point = closest[static_cast<size_t>(i)];
    if (point.face < 0) continue;
    const Vector3 m = point.interpolate(target.surface->faces(), target.normals).normalized();
    const Vector3 p = point.interpolate(target.surface->faces(), target.surface->vertices());
    const double robust = 1 / (1 + (point.distance / scale) * (point.distance / scale));
    const double weight = 0.5 * model.meanVertexArea() * model.areas()[i] * robust /
                          (noise * target.meanVertexArea * target.meanVertexArea);
    const double root = std::sqrt(weight);
    model.project(static_cast<int>(i), m, rows.col(used).data());
    const double y = m.dot(p - model.nodes().row(i).transpose()) - rows.col(used).dot(before);
    rightSides[used] = root * y;
    rows.col(used) *= root;
    ++used;
  }
  ArcEquations equations{Eigen::MatrixXd::Zero(all, all), rows * rightSides};
  equations.matrix.selfadjointView<Eigen::Lower>().rankUpdate(rows);
  equations.matrix.triangularView<Eigen::StrictlyUpper>() = equations.matrix.transpose();
  return equations;
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
    const auto mean = [&](int from, int count) { return std::max(second.segment(from, count).mean(), varianceFloor); };
    const MotionVariances updated{variances.local, mean(0, 3), mean(3, 6), mean(9, 3)};
    const double change = std::max({std::fabs(std::log(updated.translation / variances.translation)),
                                    std::fabs(std::log(updated.strain / variances.strain)),
                                    std::fabs(std::log(updated.rotation / variances.rotation))});
    variances = updated;
    if (change < 1e-3) break;
  }
  variances.strain *= strainShare;
  return variances;
}

Eigen::MatrixXd inverseOf(const Eigen::MatrixXd& positiveDefinite) {
  return positiveDefinite.llt().solve(Eigen::MatrixXd::Identity(positiveDefinite.rows(), positiveDefinite.cols()));
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

MotionPrior fixedMotionPrior() { return {fixedVariances.diagonal().cwiseInverse().asDiagonal(), wideNoise}; }

MotionTarget::MotionTarget(const ClosedSurface& layer)
    : surface(&layer),
      locator(layer.vertices(), layer.faces()),
      normals(vertexNormals(layer.vertices(), layer.faces())),
      meanVertexArea(faceAreas(layer.vertices(), layer.faces()).sum() / layer.vertexCount()),
      meanEdge(meanEdgeLength(layer.vertices(), layer.faces())) {}

std::vector<MotionTarget> motionTargets(const std::vector<ClosedSurface>& surfaces, ThreadPool& pool) {
  return pool.makeEach(static_cast<int>(surfaces.size()),
                       [&](int i) { return MotionTarget(surfaces[static_cast<size_t>(i)]); });
}

MotionFit fitMotion(const MotionModel& model, const std::vector<MotionTarget>& targets, const PropagationTree& tree,
                    const MotionPrior& prior, ThreadPool& pool, const Progress& progress) {
  MotionFit fit;
  fit.coefficients.assign(targets.size(), Eigen::VectorXd::Zero(all));
  fit.equations.resize(targets.size());
  const std::vector<std::vector<int>> levels = tree.levels();
  size_t done = 1;
  for (size_t level = 1; level < levels.size(); ++level) {
    pool.forEach(static_cast<int>(levels[level].size()), [&](int k) {
      const auto t = static_cast<size_t>(levels[level][static_cast<size_t>(k)]);
      const Eigen::VectorXd& before = fit.coefficients[static_cast<size_t>(tree.parent[t])];
      Eigen::VectorXd c = before;
      ArcEquations equations;
      for (int i = 0; i < iterations; ++i) {
        equations = equationsAt(model, targets[t], c, before, prior.noise);
        c = before + (equations.matrix + prior.precision).llt().solve(equations.vector);
      }
      fit.coefficients[t] = std::move(c);
      fit.equations[t] = std::move(equations);
    });
    done += levels[level].size();
    report(progress, static_cast<double>(done) / static_cast<double>(targets.size()));
  }
  return fit;
}

LearntPrior learnMotionPrior(const MotionModel& model, const std::vector<MotionTarget>& targets,
                             const PropagationTree& tree, ThreadPool& pool, const Progress& progress) {
  const MotionPrior wide{wideVariances.diagonal().cwiseInverse().asDiagonal(), wideNoise};
  MotionFit fit = fitMotion(model, targets, tree, wide, pool, part(progress, 0, 0.7));
  std::vector<ArcEquations> equations;
  const double temper = wideNoise / temperedNoise, unit = std::sqrt(0.5 * model.meanVertexArea());
  for (ArcEquations& e : fit.equations)
    if (e.vector.size() > 0) equations.push_back({temper * e.matrix, temper / unit * e.vector});
  LearntPrior learnt;
  learnt.variances = learnVariances(equations);
  const Eigen::MatrixXd towards = learnt.variances.diagonal().asDiagonal();
  Eigen::MatrixXd covariance = towards;
  for (int round = 0; round < covarianceRounds; ++round) {
    const Eigen::MatrixXd precision = inverseOf(covariance);
    std::vector<Eigen::MatrixXd> second(equations.size());  // moments, added up in the arcs' order
    pool.forEach(static_cast<int>(equations.size()), [&](int k) {
      const ArcEquations& e = equations[static_cast<size_t>(k)];
      second[static_cast<size_t>(k)] = inverseOf(e.matrix + precision);
      const Eigen::VectorXd c = second[static_cast<size_t>(k)] * e.vector;
      second[static_cast<size_t>(k)].noalias() += c * c.transpose();
    });
    Eigen::MatrixXd total = priorArcs * towards;
    for (const Eigen::MatrixXd& moments : second) total += moments;
    covariance = total / (static_cast<double>(equations.size()) + priorArcs);
    report(progress, 0.7 + 0.3 * (round + 1) / covarianceRounds);
  }
  learnt.prior = {inverseOf(covariance), learntNoise};
  return learnt;
}

}  // namespace sphere_propagation
