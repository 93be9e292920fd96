// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/fitting/model_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/statistics.h"
#include "vcg_ext/fitting/pose_search.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/mesh/surface_locator.h"

namespace sphere_propagation {
namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr int firstIterations = 2, startIterations = 6, allTurns = 60;
// Of the landmarks, while poses are compared, in the first steps and in those that follow.
constexpr Eigen::Index observedFirst = 165, observedThen = 500;
constexpr int posesOfFreedom = 7;          // rotation, translation, scale
constexpr double leastNoise = 0.05;        // of the surface's mean edge
constexpr double hard = 3;                 // a residual of so many sigma weighs a quarter
constexpr double independentPatches = 38;  // of a whole surface, 0.23 R each
constexpr double converged = 1e-3;         // of the mean edge

struct State {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  double scale = 1;
  Vector3 translation = Vector3::Zero();
  Eigen::VectorXd c;

  Points placed(const Points& shape) const {
    return (scale * shape * rotation.transpose()).rowwise() + translation.transpose();
  }
};

/// What is seen of the model where it lies now.
struct Observations {
  std::vector<Vector3> normals, points;  // n and y
  std::vector<double> residuals;         // n . (p - y)
  struct Place {                         // y, as landmarks with weights
    std::array<Eigen::Index, 3> landmarks;
    Vector3 weights;
  };
  std::vector<Place> places;
  Eigen::Index unseen = 0, unexplained = 0;  // landmarks and samples without a counterpart
  double distance = 0;                       // mean, of the samples that have one

  void add(const Vector3& normal, const Vector3& y, const Vector3& p, Place place) {
    normals.push_back(normal);
    points.push_back(y);
    residuals.push_back(normal.dot(p - y));
    places.push_back(std::move(place));
  }
  Eigen::Index count() const { return static_cast<Eigen::Index>(residuals.size()); }
};

class Fitting {
 public:
  Fitting(const FittingModel& model, const FittingTarget& target,
          const ModelFitParameters& parameters)
      : model_(model),
        target_(target),
        parameters_(parameters),
        modelEdge_(facesAtEdge(model.faces())),
        order_(SurfaceLocator(model.mean(), model.faces()).order()),
        leastNoise_(leastNoise *
                    (parameters.meanEdge > 0 ? parameters.meanEdge : target.meanEdge())),
        temper_(static_cast<double>(model.mean().rows() + FittingTarget::sampleCount) /
                parameters.thinning / independentPatches) {}

  /// Gauss-Newton with the first `columns` columns of the model.
  struct Solved {
    State state;
    Observations seen;  // where the last step began
    Eigen::MatrixXd information;
    double noise = 0;
    double energy = 0;
  };
  Solved solve(State state, Eigen::Index columns, int iterations, ThreadPool& pool) const {
    state.c.conservativeResizeLike(Eigen::VectorXd::Zero(columns));
    Solved solved;
    Nearby nearby;
    for (int iteration = 0; iteration < iterations; ++iteration) {
      const Points x = model_.shape(state.c);
      const Points y = state.placed(x);
      Observations seen = observe(y, nearby, pool);
      if (seen.count() == 0)
        throw SurfaceError(
            "No part of the model comes near the surface with the same side outwards.");
      std::vector<double> sizes(seen.residuals);
      for (double& size : sizes) size = std::fabs(size);
      const double noise = std::max(normalDeviation * medianOf(std::move(sizes)), leastNoise_);
      const Eigen::Index unknowns = posesOfFreedom + columns;
      Rows rows = Rows::Zero(seen.count(), unknowns);
      Eigen::VectorXd values(seen.count());
      for (Eigen::Index o = 0; o < seen.count(); ++o) {
        const auto at = static_cast<size_t>(o);
        const double r = seen.residuals[at], q = 1 / (1 + square(r / (hard * noise)));
        const double root = q / (std::sqrt(temper_) * noise);
        setRow(rows.row(o), seen.normals[at], seen.points[at], seen.places[at], state);
        values[o] = root * (r + rows.row(o).tail(columns).dot(state.c));
        rows.row(o) *= root;
      }
      Eigen::MatrixXd information = Eigen::MatrixXd::Zero(unknowns, unknowns);
      information.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
      Eigen::VectorXd pull = rows.transpose() * values;
      addAnchors(y, state, information, pull);
      information.diagonal().tail(columns) += model_.variances().head(columns).cwiseInverse();
      const double small =
          1e-9 * information.diagonal().head(posesOfFreedom).sum();  // where nothing tells the pose
      information.diagonal().head(posesOfFreedom).array() += small;
      if (!parameters_.scales) holdScale(information, pull);
      const Eigen::LLT<Eigen::MatrixXd> factor(information);
      const Eigen::VectorXd step = factor.solve(pull);
      const State before = state;
      state = moved(state, step);
      const double change =
          (state.placed(model_.shape(state.c)) - before.placed(x)).rowwise().norm().maxCoeff();
      solved = {state, std::move(seen), std::move(information), noise, 0};
      if (iteration >= 4 && change < converged * target_.meanEdge()) break;
    }
    solved.information.triangularView<Eigen::StrictlyUpper>() =
        solved.information.transpose().triangularView<Eigen::StrictlyUpper>();
    solved.energy = energyOf(solved);
    return solved;
  }

  /// dy_j / d(pose, c), 3 rows.
  Rows derivative(Eigen::Index landmark, const Vector3& y, const State& state) const {
    Rows rows = Rows::Zero(3, posesOfFreedom + state.c.size());
    for (int axis = 0; axis < 3; ++axis)
      setRow(rows.row(axis), Vector3::Unit(axis), y, {{landmark, landmark, landmark}, {1, 0, 0}},
             state);
    return rows;
  }

 private:
  static double square(double x) { return x * x; }

  /// Turns about t, so that pose and shape are as independent as they can be.
  static State moved(const State& from, const Eigen::VectorXd& step) {
    State to = from;
    const Vector3 turn = step.head<3>();
    const double angle = turn.norm();
    if (angle > 0)
      to.rotation = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() * from.rotation;
    to.translation += step.segment<3>(3);
    to.scale *= std::exp(std::clamp(step[6], -1.0, 1.0));
    to.c = step.tail(from.c.size());
    return to;
  }

  void setRow(Eigen::Ref<Eigen::RowVectorXd> row, const Vector3& n, const Vector3& y,
              const Observations::Place& place, const State& state) const {
    const Vector3 arm = y - state.translation;
    row.head<3>() = arm.cross(n).transpose();
    row.segment<3>(3) = n.transpose();
    row[6] = parameters_.scales ? n.dot(arm) : 0;
    const Vector3 inModel = state.scale * (state.rotation.transpose() * n);
    for (int k = 0; k < 3; ++k)
      if (place.weights[k] != 0)
        model_.project(place.landmarks.at(static_cast<size_t>(k)), inModel, place.weights[k],
                       row.tail(state.c.size()));
  }

  void addAnchors(const Points& y, const State& state, Eigen::MatrixXd& information,
                  Eigen::VectorXd& pull) const {
    for (const FittingAnchor& anchor : parameters_.anchors) {
      const Vector3 at = y.row(anchor.landmark).transpose();
      Rows rows = derivative(anchor.landmark, at, state);
      const Vector3 values =
          (anchor.point - at + rows.rightCols(state.c.size()) * state.c) / anchor.deviation;
      rows /= anchor.deviation;
      information.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
      pull += rows.transpose() * values;
    }
  }

  static void holdScale(Eigen::MatrixXd& information, Eigen::VectorXd& pull) {
    information.row(6).setZero();
    information.col(6).setZero();
    information(6, 6) = 1e30;  // known
    pull[6] = 0;
  }

  /// Faces that were found the last time, to look at first: of the surface, of the model.
  struct Nearby {
    std::vector<int> feet, places;
  };

  Observations observe(const Points& y, Nearby& nearby, ThreadPool& pool) const {
    const Points normals = vertexNormals(y, model_.faces());
    const SurfaceLocator moved(y, model_.faces(), order_);
    const int every = parameters_.thinning;
    const auto landmarks = (static_cast<int>(y.rows()) + every - 1) / every,
               samples = (static_cast<int>(target_.samples().rows()) + every - 1) / every;
    std::vector<SurfacePoint> feet(static_cast<size_t>(landmarks)),
        places(static_cast<size_t>(samples));
    nearby.feet.resize(feet.size(), -1);
    nearby.places.resize(places.size(), -1);
    constexpr int chunk = 128;
    const auto inChunks = [&pool](int count, const auto& f) {
      pool.forEach((count + chunk - 1) / chunk, [&](int part) {
        for (int i = part * chunk; i < std::min(count, (part + 1) * chunk); ++i) f(i);
      });
    };
    inChunks(landmarks, [&](int i) {
      const int j = i * every;
      int& near = nearby.feet[static_cast<size_t>(i)];
      feet[static_cast<size_t>(i)] =
          target_.closest(y.row(j).transpose(), normals.row(j).transpose(), near);
    });
    inChunks(samples, [&](int i) {
      const int at = i * every;
      SurfacePoint& place = places[static_cast<size_t>(i)];
      int& near = nearby.places[static_cast<size_t>(i)];
      place = moved.closest(target_.samples().row(at).transpose(),
                            target_.sampleNormals().row(at).transpose(), FittingTarget::agreement,
                            near);
      near = place.face;
    });
    Observations seen;
    for (int i = 0; i < landmarks; ++i) {
      const SurfacePoint& foot = feet[static_cast<size_t>(i)];
      const int j = i * every;
      if (foot.face < 0)
        ++seen.unseen;
      else
        seen.add(normals.row(j).transpose(), y.row(j).transpose(), target_.pointAt(foot),
                 {{j, j, j}, {1, 0, 0}});
    }
    int near = 0;
    for (int i = 0; i < samples; ++i) {
      const SurfacePoint& place = places[static_cast<size_t>(i)];
      if (place.face < 0 || modelEdge_[static_cast<size_t>(place.face)]) {
        ++seen.unexplained;
        continue;
      }
      const auto corner = [&](int k) { return model_.faces()(place.face, k); };
      Vector3 n = Vector3::Zero();
      for (int k = 0; k < 3; ++k) n += place.weights[k] * normals.row(corner(k)).transpose();
      if (!(n.norm() > 0)) continue;
      seen.add(n.normalized(), place.interpolate(model_.faces(), y),
               target_.samples().row(i * every).transpose(),
               {{corner(0), corner(1), corner(2)}, place.weights});
      seen.distance += place.distance;
      ++near;
    }
    if (near > 0) seen.distance /= near;
    return seen;
  }

  /// Minus the logarithm of the posterior, with one noise for all that are compared.
  double energyOf(const Solved& solved) const {
    const double scale = std::hypot(model_.localDeviation(), leastNoise_);
    const auto cost = [&](double r) {
      return 0.5 * hard * hard * std::log1p(square(r / (hard * scale))) / temper_;
    };
    double energy = cost(model_.radius()) * static_cast<double>(solved.seen.unexplained);
    for (const double r : solved.seen.residuals) energy += cost(r);
    const Eigen::VectorXd& c = solved.state.c;
    energy += 0.5 * (c.array().square() / model_.variances().head(c.size()).array()).sum();
    const Points y = solved.state.placed(model_.shape(c));
    for (const FittingAnchor& anchor : parameters_.anchors)
      energy += 0.5 * (y.row(anchor.landmark).transpose() - anchor.point).squaredNorm() /
                square(anchor.deviation);
    return energy;
  }

  const FittingModel& model_;
  const FittingTarget& target_;
  const ModelFitParameters& parameters_;
  std::vector<char> modelEdge_;  // of its faces, where lids were left out
  std::vector<int> order_;       // of its faces, in a tree
  double leastNoise_, temper_;
};

State at(const RigidMotion& pose, double scale = 1) {
  State state;
  state.rotation = pose.rotation;
  state.translation = pose.translation;
  state.scale = scale;
  return state;
}

void requireValid(const FittingModel& model, const ModelFitParameters& parameters) {
  requireRange("number of iterations", parameters.iterations, Range::between(1, 1000));
  requireRange("scale", parameters.scale, Range::above(0));
  requireRange("number of starts", parameters.starts, Range::between(2, 2 * allTurns));
  requireRange("thinning", parameters.thinning, Range::atLeast(1));
  requireRange("calibration", parameters.calibration, Range::above(0));
  requireRange("mean edge", parameters.meanEdge, Range::atLeast(0));
  for (const FittingAnchor& anchor : parameters.anchors) {
    requireRange("landmark of an anchor", static_cast<double>(anchor.landmark),
                 Range::between(0, static_cast<double>(model.mean().rows() - 1)));
    requireRange("standard deviation of an anchor", anchor.deviation, Range::above(0));
    if (!anchor.point.allFinite()) throw ParameterError("An anchor's place is not finite.");
  }
}

/// Where the anchors bring the mean; empty where there are too few of them.
std::optional<RigidMotion> poseOfAnchors(const FittingModel& model,
                                         const std::vector<FittingAnchor>& anchors) {
  if (anchors.size() < minPoseAnchors) return std::nullopt;
  Points from(static_cast<Eigen::Index>(anchors.size()), 3), to = from;
  for (size_t i = 0; i < anchors.size(); ++i) {
    from.row(static_cast<Eigen::Index>(i)) = model.mean().row(anchors[i].landmark);
    to.row(static_cast<Eigen::Index>(i)) = anchors[i].point.transpose();
  }
  return fitRigid(from, to);
}

/// Of those that are as likely as the best, but for a factor that says nothing, the least turned:
/// shapes that look like themselves from another side mostly lie as the model does. Null: none.
const Fitting::Solved* chosenOf(const std::vector<std::optional<Fitting::Solved>>& tried) {
  constexpr double asLikely = 3;  // logarithm of the ratio of posteriors
  double least = std::numeric_limits<double>::infinity();
  for (const auto& one : tried)
    if (one) least = std::min(least, one->energy);
  const Fitting::Solved* chosen = nullptr;
  for (const auto& one : tried)
    if (one && one->energy <= least + asLikely &&
        (!chosen || one->state.rotation.trace() > chosen->state.rotation.trace()))
      chosen = &*one;
  return chosen;
}

}  // namespace

Eigen::Matrix4d ModelFit::pose() const {
  Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
  pose.topLeftCorner<3, 3>() = scale * rotation;
  pose.topRightCorner<3, 1>() = translation;
  return pose;
}

Eigen::VectorXd ModelFit::deviations() const {
  Eigen::VectorXd deviations(static_cast<Eigen::Index>(covariance.size()));
  for (size_t j = 0; j < covariance.size(); ++j)
    deviations[static_cast<Eigen::Index>(j)] = std::sqrt(covariance[j].trace() / 3);
  return deviations;
}

ModelFit fitModel(const FittingModel& model, const FittingTarget& target, ThreadPool& pool,
                  const ModelFitParameters& parameters, const Progress& progress) {
  requireValid(model, parameters);
  const Fitting fitting(model, target, parameters);
  const Eigen::Index modes = model.modeCount();
  ModelFit fit;
  State start;
  std::optional<RigidMotion> pose = parameters.pose;
  if (!pose) pose = poseOfAnchors(model, parameters.anchors);
  if (pose) {
    start = at(*pose, parameters.scale);
  } else {
    // All of them get a start: how far they come in a few steps tells which go on.
    const auto from = [&](const std::vector<State>& states, int iterations, Eigen::Index observed) {
      ModelFitParameters thinned = parameters;
      thinned.thinning =
          std::max(parameters.thinning, static_cast<int>(model.mean().rows() / observed));
      const Fitting roughly(model, target, thinned);
      return pool.makeEach(
          static_cast<int>(states.size()), [&](int i) -> std::optional<Fitting::Solved> {
            ThreadPool own(1);
            try {
              return roughly.solve(states[static_cast<size_t>(i)], modes, iterations, own);
            } catch (const SurfaceError&) {
              return std::nullopt;  // it went astray
            }
          });
    };
    std::vector<State> states, more;
    const int half = parameters.starts / 2;
    const auto sure = static_cast<size_t>(target.closed() ? half : half + half / 2);
    for (const StartPose& one : startPoses(model, target, target.closed() ? half : allTurns, pool))
      (states.size() < sure ? states : more).push_back(at(one.motion));
    if (target.closed())
      for (const RigidMotion& motion : turnsAboutCentre(model, target)) more.push_back(at(motion));
    std::vector<std::optional<Fitting::Solved>> begun = from(more, firstIterations, observedFirst);
    std::stable_sort(begun.begin(), begun.end(), [](const auto& a, const auto& b) {
      return a && (!b || a->energy < b->energy);
    });
    for (size_t i = 0; i < begun.size() && i < static_cast<size_t>(half); ++i)
      if (begun[i]) states.push_back(begun[i]->state);
    fit.starts = static_cast<int>(states.size());
    report(progress, 0.3);
    const std::vector<std::optional<Fitting::Solved>> tried =
        from(states, startIterations, observedThen);
    const Fitting::Solved* best = chosenOf(tried);
    start = best ? best->state : states.front();
  }
  report(progress, 0.6);
  const Fitting::Solved solved =
      fitting.solve(start, model.columnCount(), parameters.iterations, pool);
  report(progress, 0.9);
  const State& state = solved.state;
  fit.landmarks = state.placed(model.shape(state.c));
  fit.rotation = state.rotation;
  fit.scale = state.scale;
  fit.translation = state.translation;
  fit.scores = state.c.head(modes);
  fit.local = state.c.tail(state.c.size() - modes);
  fit.noise = solved.noise;
  fit.logPosterior = -solved.energy;
  fit.surfaceDistance = solved.seen.distance;
  fit.unseen = parameters.thinning * static_cast<double>(solved.seen.unseen) /
               static_cast<double>(model.mean().rows());
  fit.unexplained = parameters.thinning * static_cast<double>(solved.seen.unexplained) /
                    static_cast<double>(std::max<Eigen::Index>(1, target.samples().rows()));
  const Eigen::MatrixXd covariance =
      parameters.calibration * parameters.calibration *
      Eigen::LLT<Eigen::MatrixXd>(solved.information)
          .solve(Eigen::MatrixXd::Identity(solved.information.rows(), solved.information.cols()));
  fit.scoreDeviations =
      covariance.diagonal().segment(posesOfFreedom, modes).cwiseMax(0.0).cwiseSqrt();
  fit.covariance.reserve(static_cast<size_t>(model.mean().rows()));
  for (Eigen::Index j = 0; j < model.mean().rows(); ++j) {
    if (j % parameters.thinning != 0) {
      fit.covariance.emplace_back(Eigen::Matrix3d::Zero());
      continue;
    }
    const Rows d = fitting.derivative(j, fit.landmarks.row(j).transpose(), state);
    const Eigen::Matrix3d block = d * covariance * d.transpose();
    fit.covariance.emplace_back((block + block.transpose()) / 2);  // symmetric bit for bit
  }
  report(progress, 1);
  return fit;
}

ModelFitParameters onceMoreFrom(const ModelFit& fit, const FittingModel& model,
                                ModelFitParameters parameters) {
  constexpr Eigen::Index observed = 250;
  parameters.thinning = static_cast<int>(std::max<Eigen::Index>(1, model.mean().rows() / observed));
  parameters.pose = RigidMotion{fit.rotation, fit.translation};
  parameters.scale = fit.scale;
  return parameters;
}

}  // namespace sphere_propagation
