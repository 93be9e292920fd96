// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/groupwise/population_model.h"

#include <algorithm>
#include <cmath>

#include "vcg_ext/base/conjugate_gradients.h"
#include "vcg_ext/base/statistics.h"
#include "vcg_ext/propagation/motion/dense_kernels.h"
#include "vcg_ext/propagation/motion/motion_basis.h"

namespace sphere_propagation {
namespace {

constexpr ConjugateGradientParameters posteriorSolved{1e-8, 60};

/// When trust is found again, in rounds: not before the model of those that differ least is there.
constexpr int untilTrust = 3;
/// The squared Mahalanobis distance that is trusted fully: so many times that of three quarters of
/// the shapes, and this at least. Foreign shapes among sixteen came to 150 to 500, members to 5
/// (sliding bump), 35 (ellipsoids), 55 (skulls) and 157 (hippocampi, of which three quarters stay
/// below 27).
constexpr double timesUsual = 6, leastDoubted = 60;

/// What one shape says of its coefficients.
struct Evidence {
  Eigen::MatrixXf matrix;  // H_k
  Eigen::VectorXd vector;  // h_k
  double square = 0;       // of what is observed along the normals: sum w (n . d)^2
  double anchored = 0;     // the same of anchors, with their shares

  Eigen::VectorXd times(const Eigen::VectorXd& c) const {
    const Eigen::VectorXf image = matrix * c.cast<float>();
    return image.cast<double>();
  }
};

Evidence evidenceOf(const MotionBasis& basis, const Points& displacements, const Points& normals,
                    const Eigen::VectorXd& weights, const Points& mean,
                    const std::vector<PlacedAnchor>& anchors, double beta) {
  Evidence evidence;
  const Eigen::VectorXd along = displacements.cwiseProduct(normals).rowwise().sum();
  const Points forces = weights.cwiseProduct(along).asDiagonal() * normals;
  evidence.matrix = basis.roughInformation(normals, weights).cast<float>();
  evidence.vector = basis.roughProjectAll(forces);
  evidence.square = along.cwiseAbs2().dot(weights);
  Eigen::VectorXd row(MotionBasis::columns);
  for (const PlacedAnchor& anchor : anchors) {
    const double share = shareOf(anchor, beta);
    const Vector3 gap = anchor.point - anchor.at(mean);
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(3, MotionBasis::columns);
    for (int corner = 0; corner < 3; ++corner)
      for (int i = 0; i < 3; ++i) {
        basis.project(anchor.corners[corner], Vector3::Unit(i), row.data());
        rows.row(i) += anchor.weights[corner] * row.transpose();
      }
    evidence.matrix += (share * rows.transpose() * rows).cast<float>();
    evidence.vector += share * rows.transpose() * gap;
    evidence.anchored += share * gap.squaredNorm();
  }
  return evidence;
}

/// The prior variance of each coefficient, such that a landmark's coordinates vary by `variance`
/// with each part of the model, on average over all directions: so the prior turns with the shapes.
Eigen::VectorXd priorVariances(const PopulationPose& pose, double variance) {
  const Eigen::RowVector3d centre = pose.weights.transpose() * pose.mean;
  const double square = (pose.mean.rowwise() - centre).rowwise().squaredNorm().dot(pose.weights);
  Eigen::VectorXd prior = Eigen::VectorXd::Constant(MotionBasis::columns, variance);
  prior.tail(MotionBasis::strainColumns + MotionBasis::rotationColumns) *= 3 / square;
  return prior;
}

/// Solves (beta H + P) c = beta h + P mu, from the c that is given. inverse: that of a similar
/// matrix.
void solvePosterior(const Evidence& evidence, double beta, const Eigen::MatrixXd& precision,
                    const Eigen::VectorXd& right, const Eigen::MatrixXd& inverse,
                    Eigen::VectorXd& c) {
  const auto times = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    return beta * evidence.times(x) + precision * x;
  };
  solveByConjugateGradients(
      times, [&](const Eigen::VectorXd& rest) { return inverse * rest; }, right, c,
      posteriorSolved);
}

/// At first: by how much is observed along the normals.
Eigen::VectorXd firstTrust(const std::vector<Evidence>& evidence, const Eigen::VectorXd& given) {
  if (given.size() < minTrustedShapes) return given;
  std::vector<double> squares;
  for (const Evidence& one : evidence) squares.push_back(one.square);
  const double usual = lowerQuantileOf(squares, 0.75);
  Eigen::VectorXd trust = given;
  for (Eigen::Index k = 0; k < trust.size(); ++k)
    trust[k] *= trustIn(squares[static_cast<size_t>(k)], usual);
  return trust;
}

/// By how far each shape is from the model of the others. deviations: one column per shape, of
/// which the covariance behind `precision` holds trust_k times the square, over `samples`.
Eigen::VectorXd trustByOthers(const Eigen::MatrixXd& deviations, const Eigen::MatrixXd& precision,
                              double samples, const Eigen::VectorXd& trust) {
  const Eigen::MatrixXd images = precision * deviations;
  const double sum = trust.sum();
  std::vector<double> distances;
  for (Eigen::Index k = 0; k < trust.size(); ++k) {
    const double square = deviations.col(k).dot(images.col(k)) / samples,
                 left = std::max(1 - trust[k] * square, 1e-12), rest = sum - trust[k],
                 shift = rest > 0 ? sum / rest : 1;
    distances.push_back((samples - trust[k]) * square / left * shift * shift);
  }
  const double full = std::max(leastDoubted, timesUsual * lowerQuantileOf(distances, 0.75));
  Eigen::VectorXd found(trust.size());
  for (Eigen::Index k = 0; k < found.size(); ++k)
    found[k] = trustIn(distances[static_cast<size_t>(k)], full);
  return found;
}

}  // namespace

double shareOf(const PlacedAnchor& anchor, double beta) {
  return std::min(anchor.precision / beta, 1.0);
}

PopulationFit fitPopulation(const PopulationPose& pose, const std::vector<Points>& normals,
                            const PopulationModelParameters& parameters, ThreadPool& pool,
                            const std::vector<std::vector<PlacedAnchor>>& anchors) {
  const auto count = static_cast<int>(pose.shapes.size());
  const double variance = pose.variance() / 3;
  const double beta = parameters.surfacePrecision / variance, shrink = parameters.priorShapes;
  const MotionBasis basis(pose.mean, pose.weights, 1);
  const std::vector<Evidence> evidence = pool.makeEach(count, [&](int k) {
    const auto i = static_cast<size_t>(k);
    return evidenceOf(basis, pose.shapes[i] - pose.mean, normals[i], pose.weights, pose.mean,
                      anchors.empty() ? std::vector<PlacedAnchor>() : anchors[i], beta);
  });
  const Eigen::VectorXd prior = priorVariances(pose, variance);
  Eigen::VectorXd trust = firstTrust(evidence, pose.trust);
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(prior.size(), prior.size());
  for (int k = 0; k < count; ++k)
    mean +=
        evidence[static_cast<size_t>(k)].matrix.cast<double>() * (pose.trust[k] / pose.trust.sum());

  Eigen::MatrixXd precision = prior.cwiseInverse().asDiagonal();
  Eigen::VectorXd middle = Eigen::VectorXd::Zero(prior.size());
  Eigen::MatrixXd coefficients = Eigen::MatrixXd::Zero(prior.size(), count);
  for (int round = 0;; ++round) {
    const Eigen::MatrixXd posterior = inverseOf(beta * mean + precision);
    const Eigen::VectorXd towards = precision * middle;
    pool.forEach(count, [&](int k) {
      const Evidence& one = evidence[static_cast<size_t>(k)];
      Eigen::VectorXd c = coefficients.col(k);
      solvePosterior(one, beta, precision, beta * one.vector + towards, posterior, c);
      coefficients.col(k) = c;
    });
    if (round == parameters.rounds) break;
    const double shapes = trust.sum();
    middle = coefficients * trust / shapes;
    const Eigen::MatrixXd deviations = coefficients.colwise() - middle;
    const Eigen::MatrixXd trusted = deviations * trust.asDiagonal();
    Eigen::MatrixXd covariance = trusted * deviations.transpose() + shapes * posterior;
    covariance.diagonal() += shrink * prior;
    precision = inverseOf(covariance / (shapes + shrink));
    if (count >= minTrustedShapes && (round + 1) % untilTrust == 0)
      trust = trustByOthers(deviations, precision, shapes + shrink, trust);
  }

  PopulationFit fit;
  fit.trust = trust;
  fit.precision = beta;
  fit.residuals.resize(count);
  fit.expected = pool.makeEach(
      count, [&](int k) -> Points { return pose.mean + basis.displacements(coefficients.col(k)); });
  for (int k = 0; k < count; ++k) {
    const Evidence& one = evidence[static_cast<size_t>(k)];
    const Eigen::VectorXd c = coefficients.col(k);
    double square = one.square + one.anchored - 2 * c.dot(one.vector) + c.dot(one.times(c));
    if (!anchors.empty())
      for (const PlacedAnchor& anchor : anchors[static_cast<size_t>(k)])
        square -= shareOf(anchor, beta) *
                  (anchor.point - anchor.at(fit.expected[static_cast<size_t>(k)])).squaredNorm();
    fit.residuals[k] = std::sqrt(std::max(square, 0.0));
  }
  return fit;
}

}  // namespace sphere_propagation
