// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_smoothing.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <array>
#include <cmath>

#include "tests/core/sizes.h"
#include "tests/core/test_meshes.h"
#include "vcg_ext/base/statistics.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/propagation/motion/motion_data.h"
#include "vcg_ext/propagation/motion/motion_fit.h"
#include "vcg_ext/propagation/motion/surface_errors.h"

namespace sphere_propagation {
namespace {

constexpr int layerCount = 6;
constexpr double topOfRoot = 0.8, topOfOthers = 0.76;
using Tops = std::array<double, layerCount>;
constexpr Tops rootTooHigh = {topOfRoot,   topOfOthers, topOfOthers,
                              topOfOthers, topOfOthers, topOfOthers},
               allWrong = {0.78, 0.81, 0.76, 0.8, 0.75, 0.79};

/// A ball that is cut off flat at the top, on a mesh of its own for each phase. It does not move:
/// where tops differ, the surfaces are wrong.
struct CutBall {
  std::vector<ClosedSurface> surfaces;
  Points rootMap;
  PropagationTree tree = cyclicTimeOrder(layerCount, 0);
  explicit CutBall(double scale = 1, const Tops& tops = rootTooHigh) {
    for (int i = 0; i < layerCount; ++i) {
      test::Mesh mesh = test::transformed(test::icosphereMesh(9 + i % 2),
                                          test::randomRotation(60 + i), 1, Vector3::Zero());
      if (i == 0) rootMap = mesh.vertices;
      mesh.vertices.col(2) = mesh.vertices.col(2).cwiseMin(tops[static_cast<size_t>(i)]);
      mesh.vertices *= 20 * scale;
      surfaces.emplace_back(mesh.vertices, mesh.faces, "phase " + std::to_string(i));
    }
  }
  MotionModel model() const { return MotionModel(MappedSurface(surfaces[0], rootMap)); }
  std::vector<Arc> arcs() const {
    std::vector<Arc> all;
    for (int i = 0; i < layerCount; ++i) all.push_back({i, (i + 1) % layerCount});
    return all;
  }
};

struct Smoothing {
  std::vector<Eigen::VectorXd> start;
  SmoothedMotion smoothed;
  Smoothing(const CutBall& ball, const MotionModel& model, int threads = 1) {
    ThreadPool pool(threads);
    const Sequence sequence(ball.surfaces);
    start = fitMotion(model, sequence, ball.tree, fixedMotionPrior(), pool).coefficients;
    smoothed = smoothMotion(model, sequence, 0, ball.arcs(), start, fixedMotionPrior(), pool);
  }
};

/// The energy of the header on a problem of its own accord, with no part of its solver.
class Energy {
 public:
  Energy(const CutBall& ball, const MotionModel& model, const Smoothing& s)
      : model_(model), start_(s.start), arcs_(ball.arcs()), noise_(s.smoothed.noise) {
    const Sequence sequence(ball.surfaces);
    const double tau = s.smoothed.errorInEdges;
    normals_ = vertexNormals(model.nodes(), model.faces());
    root_ = 2 * tau * sequence[0].meanEdge() *
            surfaceErrorFactor(model.nodes(), normals_, sequence[0].meanEdge());
    variance_ = 0.5 * model.meanVertexArea();
    precision_ = fixedMotionPrior().precision;
    for (int t = 1; t < layerCount; ++t) {
      std::vector<int> nearby(static_cast<size_t>(model.nodes().rows()), -1);
      data_.push_back(motionDataAt(model, sequence[t], start_[static_cast<size_t>(t)], nearby));
      const double edge = sequence[t].meanEdge();
      own_.push_back(tau * edge *
                     surfaceErrorFactor(data_.back().nodes, data_.back().directions, edge));
    }
    Eigen::VectorXd steps(static_cast<Eigen::Index>(arcs_.size()));
    for (size_t k = 0; k < arcs_.size(); ++k) {
      std::vector<double> squares;
      for (Eigen::Index i = 0; i < model.nodes().rows(); ++i)
        if (seen(arcs_[k].from, i) && seen(arcs_[k].to, i))
          squares.push_back(std::pow(along(arcs_[k].to, i) - along(arcs_[k].from, i), 2));
      steps[static_cast<Eigen::Index>(k)] = medianOf(std::move(squares));
    }
    steps = steps.array().pow(0.7).matrix();
    steps_ = (steps / steps.mean()).cwiseMax(0.05);
    steps_ /= steps_.mean();
  }
  /// z: of each layer, the root among them; error: e. Each o_t is the best there is.
  double at(const std::vector<Eigen::VectorXd>& z, const Eigen::VectorXd& error) const {
    const Eigen::VectorXd ofRoot = root_.colPivHouseholderQr().solve(error);
    double sum = variance_ * ofRoot.squaredNorm();
    for (size_t k = 0; k < arcs_.size(); ++k) {
      const Eigen::VectorXd step =
          z[static_cast<size_t>(arcs_[k].to)] - z[static_cast<size_t>(arcs_[k].from)];
      sum += step.dot(precision_ * step) / steps_[static_cast<Eigen::Index>(k)];
    }
    for (size_t k = 0; k < data_.size(); ++k) {
      const MotionData& data = data_[k];
      const Points moved = model_.basis().displacements(z[k + 1] - start_[k + 1]);
      const Eigen::VectorXd off =
          data.offsets - (moved.cwiseProduct(data.directions)).rowwise().sum() -
          data.directions.cwiseProduct(normals_).rowwise().sum().cwiseProduct(error);
      const Eigen::VectorXd weights = data.weights / noise_;
      Eigen::MatrixXd matrix = own_[k].transpose() * weights.asDiagonal() * own_[k];
      matrix.diagonal().array() += variance_;
      const Eigen::VectorXd right = own_[k].transpose() * weights.cwiseProduct(off);
      sum += off.dot(weights.cwiseProduct(off)) - right.dot(matrix.llt().solve(right));
    }
    return sum;
  }

 private:
  bool seen(int t, Eigen::Index i) const {
    return t == 0 || data_[static_cast<size_t>(t - 1)].weights[i] > 0;
  }
  double along(int t, Eigen::Index i) const {
    if (t == 0) return 0;
    const MotionData& data = data_[static_cast<size_t>(t - 1)];
    return data.directions.row(i).dot(data.nodes.row(i) - model_.nodes().row(i)) + data.offsets[i];
  }
  const MotionModel& model_;
  std::vector<Eigen::VectorXd> start_;
  std::vector<Arc> arcs_;
  double noise_, variance_;
  Points normals_;
  Eigen::MatrixXd root_, precision_;
  std::vector<MotionData> data_;
  std::vector<Eigen::MatrixXd> own_;
  Eigen::VectorXd steps_;
};

TEST(SurfaceErrors, TheFactorIsTheCovariances) {
  const CutBall ball;
  const MotionModel model = ball.model();
  Points normals = vertexNormals(model.nodes(), model.faces());
  normals.row(5).setZero();
  const double edge = 2;
  const Eigen::MatrixXd factor = surfaceErrorFactor(model.nodes(), normals, edge);
  ASSERT_LE(factor.cols(), maxErrorColumns);
  EXPECT_EQ(factor.row(5).norm(), 0);
  const Eigen::RowVector3d middle = model.nodes().colwise().mean();
  for (const auto& [i, j] : {std::pair{0, 0}, {1, 17}, {100, 101}, {400, 402}, {900, 901}}) {
    const Eigen::RowVector3d ni = normals.row(i), nj = normals.row(j);
    const double apart =
        ni.dot(model.nodes().row(i) - middle) - nj.dot(model.nodes().row(j) - middle);
    const double expected = std::exp(-(ni - nj).squaredNorm() / (2 * 0.45 * 0.45) -
                                     apart * apart / (2 * 0.25 * edge * edge));
    EXPECT_NEAR(factor.row(i).dot(factor.row(j)), expected, 0.25) << i << " " << j;
    EXPECT_LE(factor.row(i).squaredNorm(), 1 + 1e-5);
  }
}

TEST(MotionSmoothing, FindsTheSideOnWhichTheRootIsWrong) {
  const CutBall ball;
  const MotionModel model = ball.model();
  const Smoothing smoothing(ball, model);
  const double off = 20 * (topOfRoot - topOfOthers);
  double error = 0, before = 0, count = 0;
  for (Eigen::Index i = 0; i < model.nodes().rows(); ++i) {
    if (model.nodes()(i, 2) < 20 * topOfRoot - 1e-9) continue;
    error += smoothing.smoothed.rootError[i];
    for (size_t t = 1; t < layerCount; ++t) {
      const auto fallen = [&](const Eigen::VectorXd& c) {
        return std::fabs(model.movedNodes(c)(i, 2) - model.nodes()(i, 2)) / (layerCount - 1);
      };
      before += fallen(smoothing.start[t]);
    }
    ++count;
  }
  ASSERT_GT(count, 20);
  EXPECT_GT(before / count, 0.6 * off);   // arc by arc it is motion, the same in all layers
  EXPECT_LT(error / count, -0.05 * off);  // the others lie inside
  EXPECT_GE(smoothing.smoothed.noise, 1.25);
}

/// Along a line through the minimum the energy is least there: the way from where it is said to be
/// to where three values of the energy put it, as a share of what is added.
TEST(MotionSmoothing, EndsWhereTheEnergyOfTheHeaderIsLeast) {
  const CutBall ball(1, allWrong);
  const MotionModel model = ball.model();
  const Smoothing smoothing(ball, model);
  const Energy energy(ball, model, smoothing);
  const std::vector<Eigen::VectorXd>& found = smoothing.smoothed.coefficients;
  const Eigen::VectorXd& error = smoothing.smoothed.rootError;
  const auto missedBy = [&](const std::vector<Eigen::VectorXd>& added, const Eigen::VectorXd& e) {
    const auto at = [&](double share) {
      std::vector<Eigen::VectorXd> z = found;
      for (size_t t = 0; t < z.size(); ++t) z[t] += share * added[t];
      return energy.at(z, error + share * e);
    };
    const double less = at(-1), here = at(0), more = at(1);
    return (less - more) / (2 * (less + more - 2 * here));
  };
  const std::vector<Eigen::VectorXd> none(layerCount, Eigen::VectorXd::Zero(MotionBasis::columns));
  std::vector<Eigen::VectorXd> change = none, alternating = none;
  for (size_t t = 1; t < layerCount; ++t) {
    change[t] = found[t] - smoothing.start[t];
    alternating[t] = (t % 2 == 0 ? 1 : -1) * found[t];
  }
  const Eigen::VectorXd noError = Eigen::VectorXd::Zero(error.size());
  EXPECT_LT(std::fabs(missedBy(change, noError)), 1e-3);
  EXPECT_LT(std::fabs(missedBy(found, noError)), 1e-3);
  EXPECT_LT(std::fabs(missedBy(alternating, noError)), 1e-3);
  EXPECT_LT(std::fabs(missedBy(none, error)), 1e-3);
  EXPECT_LT(energy.at(found, error), energy.at(smoothing.start, noError));
}

TEST(MotionSmoothing, ThePriorsVariancesAreTimesThoseOfTheHeader) {
  const MotionVariances learnt{2, 3, 5, 7};
  const MotionPrior scaled = priorForAllAtOnce(MotionPrior::of(learnt, 2.5));
  const Eigen::MatrixXd expected = MotionPrior::of({0.45 * 2, 0.7 * 3, 6 * 5, 7}, 2.5).precision;
  EXPECT_LT((scaled.precision - expected).norm(), 1e-12 * expected.norm());
  EXPECT_EQ(scaled.noise, 2.5);
}

TEST(MotionSmoothing, HasNoUnit) {
  const CutBall ball, large(1000);
  const MotionModel model = ball.model(), largeModel = large.model();
  const Smoothing one(ball, model), other(large, largeModel);
  EXPECT_EQ(one.smoothed.noise, other.smoothed.noise);
  EXPECT_NEAR(one.smoothed.errorInEdges, other.smoothed.errorInEdges, 1e-3);
  for (size_t t = 1; t < layerCount; ++t)
    EXPECT_LT((other.smoothed.coefficients[t] / 1000 - one.smoothed.coefficients[t]).norm(),
              0.02 * one.smoothed.coefficients[t].norm() + 1e-3)
        << t;
}

TEST(MotionSmoothing, IsTheSameWithAnyNumberOfThreads) {
  const CutBall ball;
  const MotionModel model = ball.model();
  const Smoothing three(ball, model, 3);
  if (test::underSanitizer()) return;  // a second run meets what the first did
  EXPECT_EQ(Smoothing(ball, model, 1).smoothed.coefficients, three.smoothed.coefficients);
}

TEST(MotionSmoothing, LayersOnNoArcStayAsTheyAre) {
  const CutBall ball;
  const MotionModel model = ball.model();
  ThreadPool pool;
  const Sequence sequence(ball.surfaces);
  std::vector<Eigen::VectorXd> start(layerCount, Eigen::VectorXd::Zero(MotionBasis::columns));
  start[3].setConstant(1);
  const std::vector<Arc> arcs = {{0, 1}, {1, 2}, {2, 4}, {4, 5}, {5, 0}};
  const SmoothedMotion smoothed =
      smoothMotion(model, sequence, 0, arcs, start, fixedMotionPrior(), pool);
  EXPECT_EQ(smoothed.coefficients[3], start[3]);
  EXPECT_NE(smoothed.coefficients[4], start[4]);
  EXPECT_EQ(smoothMotion(model, sequence, 0, {}, start, fixedMotionPrior(), pool).coefficients,
            start);
}

}  // namespace
}  // namespace sphere_propagation
