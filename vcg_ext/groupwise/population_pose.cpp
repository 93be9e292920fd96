// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/groupwise/population_pose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "vcg_ext/base/dense_cholesky.h"
#include "vcg_ext/base/rotation.h"
#include "vcg_ext/base/statistics.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/mesh/vertex_locator.h"

namespace sphere_propagation {
namespace {

/// Rotation times scale that takes the shape to what it was aligned to.
Eigen::Matrix3d turnOf(const Points& shape, const Points& aligned, Alignment alignment) {
  if (alignment == Alignment::None) return Eigen::Matrix3d::Identity();
  const Points from = shape.rowwise() - shape.colwise().mean(),
               to = aligned.rowwise() - aligned.colwise().mean();
  const double scale = alignment == Alignment::Similarity ? to.norm() / from.norm() : 1;
  return scale * bestRotation(to.transpose() * from);
}

constexpr int mostRounds = 10;
constexpr double poseConverged = 1e-4;  // the farthest that a shape moved in a round, of its size
constexpr double longestTurn = 0.3;     // in a round
/// What a turn costs by its square and the shape's, where the most that normals show of it is 2 /
/// 3: so one call goes a part of the way, and landmarks have time to slide back before the pose
/// follows them.
constexpr double turnCost = 1;
/// How much more may shapes differ along the normals, in squares, as they lie than as Procrustes
/// alignment lays them?
constexpr double frameShare = 1.5;
/// So far off the mean, times three quarters of the shapes, shapes begin to be doubted.
constexpr double twice = 2;
constexpr int doubts = 2;  // how often: strangers hide each other in the first mean

Eigen::RowVector3d centreOf(const Points& points, const Eigen::VectorXd& weights) {
  return weights.transpose() * points;
}

double sizeOf(const Points& points, const Eigen::VectorXd& weights) {
  const Points centred = points.rowwise() - centreOf(points, weights);
  return std::sqrt(centred.rowwise().squaredNorm().dot(weights));
}

/// One shape on its way to the mean.
struct MovingShape {
  Points points;
  Eigen::Matrix3d turn;              // of what it was, with its scale
  Vector3 turned = Vector3::Zero();  // by how much by now, about this axis
};

/// A small turn, a shift and, where it may, a change of size towards the mean (Gauss and Newton).
/// Returns how far, of the shape's size.
double moveTowards(const VertexLocator& mean, const Eigen::VectorXd& weights, const Points& normals,
                   bool scaled, MovingShape& shape) {
  using Vector7 = Eigen::Matrix<double, 7, 1>;
  const Eigen::RowVector3d centre = centreOf(shape.points, weights);
  Eigen::Matrix<double, 7, 7> system = Eigen::Matrix<double, 7, 7>::Zero();
  Vector7 right = Vector7::Zero();
  for (Eigen::Index j = 0; j < weights.size(); ++j) {
    const Vector3 arm = (shape.points.row(j) - centre).transpose(),
                  normal = (shape.turn * normals.row(j).transpose()).stableNormalized();
    Vector7 moves;
    moves << arm.cross(normal), normal, arm.dot(normal);
    const Vector3 point = shape.points.row(j).transpose();
    const double gap = (mean.points().row(mean.nearest(point)).transpose() - point).dot(normal);
    system.noalias() += weights[j] * moves * moves.transpose();
    right += weights[j] * gap * moves;
  }
  const double size = sizeOf(shape.points, weights);
  system.diagonal().head<3>().array() += turnCost * size * size;
  right.head<3>() -= turnCost * size * size * shape.turned;
  if (!scaled) {
    system.row(6).setZero();
    system.col(6).setZero();
    system(6, 6) = 1;
    right[6] = 0;
  }
  const Vector7 step = solveSymmetric(system, right);
  if (!step.allFinite()) return 0;
  const double angle = step.head<3>().norm(), scale = std::exp(step[6]);
  const Eigen::Matrix3d rotation =
      angle > 0 ? Eigen::AngleAxisd(std::min(angle, longestTurn), Vector3(step.head<3>() / angle))
                      .toRotationMatrix()
                : Eigen::Matrix3d::Identity();
  const Eigen::RowVector3d to = centre + step.segment<3>(3).transpose();
  shape.points =
      ((shape.points.rowwise() - centre) * (scale * rotation).transpose()).rowwise() + to;
  shape.turn = scale * rotation * shape.turn;
  if (angle > 0) shape.turned += std::min(1.0, longestTurn / angle) * step.head<3>();
  return angle + step.segment<3>(3).norm() / size + std::fabs(step[6]);
}

/// How far each surface lies from the mean's, wherever their landmarks are: squared, along the
/// normals, from its nearest landmarks.
std::vector<double> distancesFromMean(const PopulationPose& pose,
                                      const std::vector<Points>& normals, ThreadPool& pool) {
  const auto count = static_cast<int>(pose.shapes.size());
  const VertexLocator mean(pose.mean);
  return pool.makeEach(count, [&](int k) {
    const auto i = static_cast<size_t>(k);
    double sum = 0;
    for (Eigen::Index j = 0; j < pose.mean.rows(); ++j) {
      const Vector3 point = pose.shapes[i].row(j).transpose();
      const Vector3 normal = (pose.turns[i] * normals[i].row(j).transpose()).stableNormalized();
      const double along = (pose.mean.row(mean.nearest(point)).transpose() - point).dot(normal);
      sum += pose.weights[j] * along * along;
    }
    return sum;
  });
}

/// Of squares; none counts for more than what is beyond doubt, so that one stranger, which fits
/// nowhere, does not decide for all.
double sumWithinDoubt(const std::vector<double>& squares) {
  const double most = static_cast<int>(squares.size()) < minTrustedShapes
                          ? std::numeric_limits<double>::infinity()
                          : twice * twice * lowerQuantileOf(squares, 0.75);
  double sum = 0;
  for (const double square : squares) sum += std::min(square, most);
  return sum;
}

/// Of the shapes, those count that are trusted.
Points averageOf(const std::vector<Points>& shapes, const Eigen::VectorXd& trust) {
  Points sum = Points::Zero(shapes.front().rows(), 3);
  for (size_t k = 0; k < shapes.size(); ++k) sum += trust[static_cast<Eigen::Index>(k)] * shapes[k];
  return sum / trust.sum();
}

Eigen::VectorXd averageAreas(const std::vector<Points>& shapes, const Triangles& faces,
                             const Eigen::VectorXd& trust) {
  Eigen::VectorXd areas = Eigen::VectorXd::Zero(shapes.front().rows());
  for (size_t k = 0; k < shapes.size(); ++k)
    areas += trust[static_cast<Eigen::Index>(k)] * vertexAreas(shapes[k], faces);
  return areas / areas.sum();
}

}  // namespace

double trustIn(double distance, double full) {
  if (!(distance > full)) return 1;
  return full > 0 ? std::max(0.0, 2 - distance / full) : 0;
}

double PopulationPose::variance() const {
  double sum = 0;
  for (size_t k = 0; k < shapes.size(); ++k)
    sum += trust[static_cast<Eigen::Index>(k)] *
           (shapes[k] - mean).rowwise().squaredNorm().dot(weights);
  return sum / trust.sum();
}

PopulationPose poseOf(const std::vector<Points>& landmarks, const Triangles& faces,
                      Alignment alignment) {
  ProcrustesParameters parameters;
  parameters.alignment = alignment;
  parameters.areaWeights = true;
  parameters.tolerance = 1e-8;
  parameters.iterations = 100;
  std::vector<TrainingSet::Shape> named;
  named.reserve(landmarks.size());
  for (const Points& shape : landmarks) named.push_back({"", shape});
  Aligned aligned = alignShapes(TrainingSet(std::move(named), faces), parameters);
  PopulationPose pose;
  pose.mean = std::move(aligned.mean);
  for (size_t k = 0; k < landmarks.size(); ++k) {
    const Points& shape = aligned.shapes.shapes()[k].landmarks;
    pose.turns.push_back(turnOf(landmarks[k], shape, alignment));
    pose.shapes.push_back(shape);
  }
  pose.trust = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(landmarks.size()));
  pose.weights = averageAreas(pose.shapes, faces, pose.trust);
  return pose;
}

PopulationPose poseBySurfaces(const std::vector<Points>& landmarks,
                              const std::vector<Points>& normals, const Triangles& faces,
                              Alignment alignment, const PopulationPose& from, ThreadPool& pool) {
  if (alignment == Alignment::None) {
    PopulationPose pose = poseOf(landmarks, faces, alignment);
    pose.trust = from.trust;
    pose.weights = averageAreas(pose.shapes, faces, pose.trust);
    pose.mean = averageOf(pose.shapes, pose.trust);
    return pose;
  }
  const bool scaled = alignment == Alignment::Similarity;
  const auto count = static_cast<int>(landmarks.size());
  std::vector<MovingShape> shapes(landmarks.size());
  for (size_t k = 0; k < landmarks.size(); ++k) {
    const Points turned = landmarks[k] * from.turns[k].transpose();
    shapes[k].turn = from.turns[k];
    shapes[k].points = turned.rowwise() +
                       (centreOf(from.shapes[k], from.weights) - centreOf(turned, from.weights));
  }
  PopulationPose pose;
  pose.trust = from.trust;
  const double trusted = pose.trust.sum();
  const auto look = [&] {
    pose.mean = Points::Zero(landmarks.front().rows(), 3);
    for (size_t k = 0; k < shapes.size(); ++k)
      pose.mean += pose.trust[static_cast<Eigen::Index>(k)] / trusted * shapes[k].points;
  };
  const auto enlarge = [&](double unit) {
    for (MovingShape& shape : shapes) {
      shape.points *= unit;
      shape.turn *= unit;
    }
  };
  std::vector<double> moved(landmarks.size());
  look();
  for (int round = 0; round < mostRounds; ++round) {
    pose.weights = vertexAreas(pose.mean, faces);
    pose.weights /= pose.weights.sum();
    const double size = sizeOf(pose.mean, pose.weights);
    const VertexLocator mean(pose.mean);
    pool.forEach(count, [&](int k) {
      const auto i = static_cast<size_t>(k);
      moved[i] = moveTowards(mean, pose.weights, normals[i], scaled, shapes[i]);
    });
    look();
    if (scaled) {  // The mean keeps its size, or all would shrink to a point.
      enlarge(size / sizeOf(pose.mean, pose.weights));
      look();
    }
    if (*std::max_element(moved.begin(), moved.end()) < poseConverged) break;
  }
  // Into the frame of the first shape.
  const Eigen::Matrix3d back = bestRotation(shapes.front().turn.transpose());
  const Eigen::RowVector3d centre = centreOf(shapes.front().points, pose.weights),
                           there = centreOf(landmarks.front(), pose.weights);
  for (const MovingShape& shape : shapes) {
    pose.shapes.emplace_back(((shape.points.rowwise() - centre) * back.transpose()).rowwise() +
                             there);
    pose.turns.emplace_back(back * shape.turn);
  }
  pose.weights = averageAreas(pose.shapes, faces, pose.trust);
  pose.mean = averageOf(pose.shapes, pose.trust);
  return pose;
}

namespace {

struct DoubtedPose {
  PopulationPose pose;
  std::vector<double> squares;  // of the distances from its mean
};

/// Whom to trust, and the pose again where that is not everyone.
DoubtedPose doubted(PopulationPose pose, const std::vector<Points>& landmarks,
                    const std::vector<Points>& normals, const Triangles& faces, Alignment alignment,
                    ThreadPool& pool) {
  const auto count = static_cast<int>(landmarks.size());
  std::vector<double> squares = distancesFromMean(pose, normals, pool);
  for (int time = 0; time < doubts && count >= minTrustedShapes; ++time) {
    const double usual = std::sqrt(lowerQuantileOf(squares, 0.75));
    for (int k = 0; k < count; ++k)
      pose.trust[k] = trustIn(std::sqrt(squares[static_cast<size_t>(k)]), twice * usual);
    if (pose.trust.minCoeff() == 1) break;
    pose = poseBySurfaces(landmarks, normals, faces, alignment, pose, pool);
    squares = distancesFromMean(pose, normals, pool);
  }
  return {std::move(pose), std::move(squares)};
}

}  // namespace

PopulationPose firstPose(const std::vector<Points>& landmarks, const std::vector<Points>& normals,
                         const Triangles& faces, Alignment alignment, ThreadPool& pool) {
  const auto found = [&](const PopulationPose& from) {
    return doubted(poseBySurfaces(landmarks, normals, faces, alignment, from, pool), landmarks,
                   normals, faces, alignment, pool);
  };
  PopulationPose given = poseOf(landmarks, faces, Alignment::None);
  if (alignment == Alignment::None) return found(given).pose;
  for (Points& shape : given.shapes)
    shape.rowwise() +=
        centreOf(given.shapes.front(), given.weights) - centreOf(shape, given.weights);
  const DoubtedPose lie = found(given), turned = found(poseOf(landmarks, faces, alignment));
  return sumWithinDoubt(lie.squares) <= frameShare * sumWithinDoubt(turned.squares) ? lie.pose
                                                                                    : turned.pose;
}

double distanceAlongNormals(const PopulationPose& pose, const Points& landmarks,
                            const Points& normals, Alignment alignment) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Points gaps = pose.mean - landmarks;
  if (alignment != Alignment::None) {
    const Points from = landmarks.rowwise() - centreOf(landmarks, pose.weights),
                 to = pose.mean.rowwise() - centreOf(pose.mean, pose.weights);
    const Points weighted = pose.weights.asDiagonal() * from;
    turn = bestRotation(to.transpose() * weighted);
    if (alignment == Alignment::Similarity)
      turn *= sizeOf(pose.mean, pose.weights) / sizeOf(landmarks, pose.weights);
    gaps = to - from * turn.transpose();
  }
  const Points turned = (normals * turn.transpose()).rowwise().normalized();
  const Eigen::VectorXd along = gaps.cwiseProduct(turned).rowwise().sum();
  return std::sqrt(along.cwiseAbs2().dot(pose.weights));
}

}  // namespace sphere_propagation
