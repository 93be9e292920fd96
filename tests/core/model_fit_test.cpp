// SPDX-License-Identifier: GPL-3.0-only
// On bodies whose landmarks are known, as they are made of them.

#include "vcg_ext/fitting/model_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/core/sizes.h"
#include "tests/core/test_meshes.h"
#include "tests/core/test_shapes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/fitting/fit_calibration.h"
#include "vcg_ext/fitting/fitted_map.h"
#include "vcg_ext/fitting/mirrored_fit.h"
#include "vcg_ext/fitting/sized_fit.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/model/shape_deviation.h"
#include "vcg_ext/remeshing/remeshing.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation::test {
namespace {

constexpr int frequency = 6;

/// A body like an egg with a nose, which looks like itself from one side only. parameters: three,
/// about standard normal.
Points body(const Points& directions, const Vector3& p) {
  Points points = directions;
  for (auto x : points.rowwise()) {
    const Vector3 u = x.transpose();
    const double nose = std::exp(-8 * (u - Vector3(0.6, 0.8, 0)).squaredNorm());
    x = 20 * (1 + 0.15 * u[2] + (0.4 + 0.1 * p[0]) * nose + 0.08 * p[1] * u[0] * u[2]) *
        Eigen::RowVector3d(1.5 + 0.15 * p[2], 1.1, 0.8).cwiseProduct(u.transpose());
  }
  return points;
}

ShapeModel eggModel(int shapes, unsigned seed = 1) {
  Random random(seed);
  const Icosphere sphere = icosphere(frequency);
  std::vector<Points> all;
  for (int k = 0; k < shapes; ++k)
    all.push_back(body(sphere.vertices, {random.normal(), random.normal(), random.normal()}));
  return buildShapeModel(trainingSet(all, sphere.faces));
}

/// Another egg, in a finer mesh of its own, and where its landmarks are.
struct Egg {
  Mesh mesh;
  Points landmarks;
};

Egg egg(const Vector3& p, const Eigen::Matrix3d& turn = Eigen::Matrix3d::Identity(),
        const Vector3& shift = Vector3::Zero()) {
  Mesh mesh = icosphereMesh(11);
  // A mesh of its own: turned against the icosphere of the landmarks.
  mesh.vertices = body(mesh.vertices * randomRotation(5).transpose(), p);
  Egg made{mesh, body(icosphere(frequency).vertices, p)};
  made.mesh.vertices = moved(made.mesh.vertices, turn, 1, shift);
  made.landmarks = moved(made.landmarks, turn, 1, shift);
  return made;
}

/// Without the faces beyond a plane.
Mesh cut(Mesh mesh, const Vector3& normal, double offset) {
  Triangles kept(mesh.faces.rows(), 3);
  Eigen::Index count = 0;
  for (auto face : mesh.faces.rowwise()) {
    bool stays = true;
    for (const int v : face) stays = stays && mesh.vertices.row(v).dot(normal) < offset;
    if (stays) kept.row(count++) = face;
  }
  mesh.faces = kept.topRows(count);
  return mesh;
}

double meanError(const Points& a, const Points& b) { return (a - b).rowwise().norm().mean(); }

class ModelFitting : public testing::Test {
 protected:
  FittingTarget target(const Mesh& mesh) const { return {mesh.vertices, mesh.faces, "egg"}; }
  ModelFit fit(const Mesh& mesh, const ModelFitParameters& parameters = {}) {
    return fitModel(model_, target(mesh), pool_, parameters);
  }
  static ModelFitParameters searching() {
    ModelFitParameters parameters;
    parameters.pose = std::nullopt;
    return parameters;
  }

  ThreadPool pool_{2};
  ShapeModel shapes_ = eggModel(12);
  FittingModel model_{shapes_, pool_};
};

TEST_F(ModelFitting, FindsTheLandmarksOfAShapeOfTheFamily) {
  const Egg other = egg({0.8, -1.1, 0.5});
  const ModelFit found = fit(other.mesh);
  EXPECT_LT(meanError(found.landmarks, other.landmarks),
            0.2 * meanError(model_.mean(), other.landmarks));
  EXPECT_LT(found.surfaceDistance, 0.1);
  EXPECT_EQ(found.unseen, 0);
  EXPECT_EQ(found.starts, 1);
}

TEST_F(ModelFitting, FindsThePoseFromAnywhere) {
  for (unsigned seed = 1; seed <= static_cast<unsigned>(sizeFor(3, 1)); ++seed) {
    const Egg other = egg({-0.7, 0.4, 1.2}, randomRotation(seed), {100, -50, 7});
    const ModelFit found = fit(other.mesh, searching());
    EXPECT_GT(found.starts, 1);
    EXPECT_LT(meanError(found.landmarks, other.landmarks), 0.3);
    EXPECT_LT((found.rotation - randomRotation(seed)).norm(), 0.05);
    EXPECT_NEAR(found.rotation.determinant(), 1, 1e-12);
  }
}

TEST_F(ModelFitting, TellsAMirrorImage) {
  const Egg right = egg({-0.7, 0.4, 1.2}, randomRotation(2), {100, -50, 7});
  Mesh image = right.mesh;
  image.vertices.col(1) *= -1;
  image.faces.col(0).swap(image.faces.col(1));
  const auto advantage = [this](const Mesh& mesh) {
    return advantageOfMirrorImage(model_, target(mesh), fit(mesh, searching()), false, pool_);
  };
  const double ofImage = advantage(image);
  EXPECT_GT(ofImage, clearAdvantage);
  if (underSanitizer()) return;
  const double ofRight = advantage(right.mesh);
  EXPECT_LT(ofRight, -clearAdvantage);
  EXPECT_NEAR(ofImage, -ofRight, 0.1 * ofImage);
}

TEST_F(ModelFitting, CompletesAPartOfASurface) {
  const Egg other = egg({1, 0.5, -0.5}, randomRotation(9), {0, 20, 0});
  const Vector3 up = randomRotation(9).col(2);
  const double edge = up.dot(Vector3(0, 20, 0)) + 6;
  const Mesh part = cut(other.mesh, up, edge);
  ASSERT_FALSE(target(part).closed());
  const ModelFit found = fit(part, searching());
  EXPECT_LT(meanError(found.landmarks, other.landmarks), 0.6);
  EXPECT_GT(found.unseen, 0.1);
  // What was not seen is known less well, along the normal, where shapes have much of their own.
  const FittingModel loose(shapes_, pool_, {11, 1});
  const ModelFit loosely = fitModel(loose, target(part), pool_, searching());
  double seen = 0, unseen = 0;
  int seenCount = 0, unseenCount = 0;
  const Points normals = vertexNormals(loosely.landmarks, model_.faces());
  for (Eigen::Index j = 0; j < normals.rows(); ++j) {
    const Vector3 n = normals.row(j).transpose();
    const double sd = std::sqrt(n.dot(loosely.covariance[static_cast<size_t>(j)] * n));
    const double height = up.dot(other.landmarks.row(j)) - edge;
    if (height < -4) seen += sd, ++seenCount;
    if (height > 4) unseen += sd, ++unseenCount;
  }
  EXPECT_GT(unseen / unseenCount, 2 * seen / seenCount);
}

// Whatever the unit and the frame: lengths scale, places move along. What is turned is sampled at
// other points, which changes little.
TEST_F(ModelFitting, IsEquivariant) {
  const Egg other = egg({0.3, 0.9, -1});
  const ModelFit found = fit(other.mesh);
  const double unit = 0.1;
  ShapeModel small = shapes_;
  small.mean *= unit;
  small.eigenvalues *= unit * unit;
  small.scores *= unit;
  const FittingModel scaled(small, pool_);
  const Vector3 shift(3, 2, 1);
  const auto again = [&](const Eigen::Matrix3d& turn) {
    const Points vertices = moved(other.mesh.vertices, turn, unit, shift);
    ModelFitParameters parameters;
    parameters.pose = RigidMotion{turn, shift};
    return fitModel(scaled, FittingTarget(vertices, other.mesh.faces), pool_, parameters);
  };
  const ModelFit as = again(Eigen::Matrix3d::Identity());
  EXPECT_LT(largestDifference(as.landmarks,
                              moved(found.landmarks, Eigen::Matrix3d::Identity(), unit, shift)),
            1e-6);
  EXPECT_NEAR(as.noise, unit * found.noise, 1e-8);
  EXPECT_LT((as.deviations() - unit * found.deviations()).cwiseAbs().maxCoeff(), 1e-7);
  const Eigen::Matrix3d turn = randomRotation(21);
  EXPECT_LT(largestDifference(again(turn).landmarks, moved(found.landmarks, turn, unit, shift)),
            0.02);
}

TEST_F(ModelFitting, IsTheSameWithAnyNumberOfThreads) {
  const Egg other = egg({0.3, 0.9, -1}, randomRotation(4));
  ThreadPool one(1), four(4);
  const ModelFit b = fitModel(model_, target(other.mesh), four, searching());
  if (underSanitizer()) return;  // a second run meets what the first did
  const ModelFit a = fitModel(model_, target(other.mesh), one, searching());
  EXPECT_TRUE(a.landmarks == b.landmarks);
  EXPECT_TRUE(a.covariance == b.covariance);
  EXPECT_TRUE(a.scores == b.scores);
}

TEST_F(ModelFitting, ScalesWhereAsked) {
  Egg other = egg({0.5, -0.2, 0.4});
  other.mesh.vertices *= 1.3;
  other.landmarks *= 1.3;
  ModelFitParameters parameters;
  parameters.scales = true;
  const ModelFit found = fit(other.mesh, parameters);
  EXPECT_NEAR(found.scale, 1.3, 0.03);
  EXPECT_LT(meanError(found.landmarks, other.landmarks), 0.4);
  EXPECT_EQ(fit(egg({0.5, -0.2, 0.4}).mesh).scale, 1);
}

TEST_F(ModelFitting, TellsTheSizeThatItIsNotHeldTo) {
  const auto own = [this](double size) {
    Egg other = egg({0.5, -0.2, 0.4});
    other.mesh.vertices *= size;
    const Mesh part = cut(other.mesh, Vector3::UnitY(), 12 * size);
    return fitOfOwnSize(model_, target(part), fit(part), {}, pool_);
  };
  const SizedFit larger = own(1.3);
  EXPECT_GT(larger.advantage, clearAdvantage);
  EXPECT_NEAR(larger.scale, 1.3, 0.05);
  const SizedFit same = own(1);
  EXPECT_LT(same.advantage, clearAdvantage);
  EXPECT_NEAR(same.scale, 1, 0.03);
}

TEST_F(ModelFitting, GoesThroughAnchors) {
  const Egg other = egg({0.8, -1.1, 0.5});
  ModelFitParameters parameters;
  for (const Eigen::Index j : {0, 100, 200, 300})
    parameters.anchors.push_back({j, other.landmarks.row(j).transpose(), 0.01});
  const ModelFit found = fit(other.mesh, parameters);
  for (const FittingAnchor& anchor : parameters.anchors)
    EXPECT_LT((found.landmarks.row(anchor.landmark).transpose() - anchor.point).norm(), 0.05);
  // One that cannot be is not smoothed away either: it pulls its landmark off the surface.
  parameters.anchors = {{0, other.landmarks.row(0).transpose() + Vector3(0, 0, 3), 0.01}};
  EXPECT_LT((fit(other.mesh, parameters).landmarks.row(0).transpose() - parameters.anchors[0].point)
                .norm(),
            0.2);
}

TEST_F(ModelFitting, TakesThePoseFromThreeAnchors) {
  const Egg other = egg({0.8, -1.1, 0.5}, randomRotation(2), {5, 5, 500});
  ModelFitParameters parameters = searching();
  for (const Eigen::Index j : {0, 120, 240})
    parameters.anchors.push_back({j, other.landmarks.row(j).transpose(), 0.5});
  const ModelFit found = fit(other.mesh, parameters);
  EXPECT_EQ(found.starts, 1);
  EXPECT_LT(meanError(found.landmarks, other.landmarks), 0.3);
}

// A model without modes is a mean and a Gaussian process.
TEST_F(ModelFitting, FitsByTheLocalDeformationAlone) {
  FittingModelParameters parameters;
  parameters.modes = 0;
  parameters.localDeviation = 2;
  const FittingModel local(shapes_, pool_, parameters);
  const Egg other = egg({0.8, -1.1, 0.5});
  const ModelFit found = fitModel(local, target(other.mesh), pool_);
  EXPECT_EQ(found.scores.size(), 0);
  EXPECT_LT(found.surfaceDistance, 0.3);
}

TEST_F(ModelFitting, ProjectsAsItDeforms) {
  Random random(3);
  Eigen::VectorXd c(model_.columnCount());
  for (double& value : c) value = random.normal();
  const Points deformed = model_.shape(c);
  const Vector3 n = random.direction();
  for (const Eigen::Index j : {0, 77, 361}) {
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(c.size());
    model_.project(j, n, 2, row);
    EXPECT_NEAR(row.dot(c), 2 * n.dot((deformed - model_.mean()).row(j).transpose()), 1e-9);
  }
}

// By the definition: models of all others, made anew.
TEST(FittingModel, LearnsWhatItCannotShow) {
  ThreadPool pool(1);
  const std::vector<Points> shapes = ellipsoids(6, 2);
  const ShapeModel model = modelOf(shapes);
  double sum = 0;
  for (size_t k = 0; k < shapes.size(); ++k) {
    std::vector<Points> others = shapes;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    const ShapeModel rest = modelOf(others);
    const Points difference = shapes[k] - rest.mean;
    const Eigen::Map<const Eigen::VectorXd> d(difference.data(), difference.size());
    sum += (d - rest.modes * (rest.modes.transpose() * d)).squaredNorm();
  }
  const double expected = std::sqrt(sum / static_cast<double>(6 * model.mean.size()));
  EXPECT_NEAR(learntLocalDeviation(model, 100, pool).value(), expected, 1e-9);
  EXPECT_NEAR(FittingModel(model, pool).localDeviation(), expected, 1e-9);
  EXPECT_EQ(FittingModel(model, pool, {3, 0.0}).columnCount(), 3);
}

// Of the kernel the columns' squares make at most the variance of every coordinate.
TEST_F(ModelFitting, HasAKernelOfUnitVariance) {
  const FittingModel loose(shapes_, pool_, {11, 1});
  for (const Eigen::Index j : {0, 77, 361}) {
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(loose.columnCount());
    loose.project(j, Vector3::UnitY(), 1, row);
    const double variance = row.tail(loose.columnCount() - loose.modeCount()).squaredNorm();
    EXPECT_LE(variance, 1 + 1e-9);
    EXPECT_GT(variance, 0.8);
  }
}

TEST_F(ModelFitting, SpreadsSamplesByArea) {
  const Egg other = egg({0, 0, 0});
  const FittingTarget surface = target(other.mesh);
  EXPECT_TRUE(surface.closed());
  EXPECT_EQ(surface.samples().rows(), FittingTarget::sampleCount);
  const Eigen::VectorXd areas = faceAreas(other.mesh.vertices, other.mesh.faces);
  EXPECT_NEAR(surface.area(), areas.sum(), 1e-9);
  double upper = 0;
  for (Eigen::Index f = 0; f < areas.size(); ++f)
    for (int k = 0; k < 3; ++k)
      upper += other.mesh.vertices(other.mesh.faces(f, k), 2) > 0 ? areas[f] / 3 : 0;
  const double share = static_cast<double>((surface.samples().col(2).array() > 0).count()) /
                       static_cast<double>(surface.samples().rows());
  EXPECT_NEAR(share, upper / areas.sum(), 0.02);
  for (Eigen::Index i = 0; i < surface.samples().rows(); ++i)
    EXPECT_GT(surface.sampleNormals().row(i).dot(surface.samples().row(i)), 0);
}

// Landmarks of the surface's own, through a map that is certified.
TEST_F(ModelFitting, GivesTheSurfaceAMap) {
  const Egg other = egg({0.8, -1.1, 0.5}, randomRotation(8), {1, 2, 3});
  const ModelFit found = fit(other.mesh, searching());
  const ClosedSurface surface(other.mesh.vertices, other.mesh.faces, "egg");
  ASSERT_TRUE(hasMap(model_));
  const PropagatedLayer mapped = mapOfFit(model_, found, surface, pool_);
  EXPECT_TRUE(certify(mapped.map().faces(), mapped.map().positions()).valid());
  const Remeshed own = remesh(mapped.map(), icosphere(frequency).vertices);
  EXPECT_LT(meanError(own.landmarks, other.landmarks), 0.3);

  ShapeModel part = shapes_;
  part.faces = part.faces.topRows(part.faces.rows() - 4).eval();
  const FittingModel withoutLid(part, pool_);
  EXPECT_FALSE(hasMap(withoutLid));
  EXPECT_THROW(mapOfFit(withoutLid, found, surface, pool_), ParameterError);
}

// A closed mesh that is no icosphere has a map of its own, the same for all that it is fitted to.
TEST_F(ModelFitting, GivesMapsFromAnyClosedModel) {
  ShapeModel other = shapes_;
  // The same surface, one edge turned.
  const int a = other.faces(0, 0), b = other.faces(0, 1), c = other.faces(0, 2);
  for (Eigen::Index f = 1; f < other.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      if (other.faces(f, k) == b && other.faces(f, (k + 1) % 3) == a) {
        const int d = other.faces(f, (k + 2) % 3);
        other.faces.row(0) << a, d, c;
        other.faces.row(f) << d, b, c;
        f = other.faces.rows();
        break;
      }
  const FittingModel model(other, pool_);
  ASSERT_FALSE(icosphereFrequency(model.mean().rows(), model.faces()));
  ASSERT_TRUE(hasMap(model));
  std::vector<Points> own;
  for (const Egg& one : {egg({0.8, -1.1, 0.5}), egg({-0.3, 0.4, 1})}) {
    const ModelFit found = fitModel(model, target(one.mesh), pool_);
    EXPECT_LT(meanError(found.landmarks, one.landmarks), 0.3);
    const ClosedSurface surface(one.mesh.vertices, one.mesh.faces, "egg");
    const PropagatedLayer mapped = mapOfFit(model, found, surface, pool_);
    EXPECT_TRUE(certify(mapped.map().faces(), mapped.map().positions()).valid());
    own.push_back(remesh(mapped.map(), icosphere(frequency).vertices).landmarks);
  }
  // Landmarks that correspond move as the bodies do from one to the other.
  const Points there = body(icosphere(frequency).vertices, {0.8, -1.1, 0.5}),
               here = body(icosphere(frequency).vertices, {-0.3, 0.4, 1});
  EXPECT_LT(meanError(own[1], own[0]), 1.3 * meanError(here, there));
}

// As if it had been built from the others.
TEST_F(ModelFitting, LeavesAShapeOutOfAModel) {
  std::vector<Points> others;
  for (Eigen::Index k = 0; k < 12; ++k)
    if (k != 4) others.push_back(shapes_.shape(Eigen::VectorXd(shapes_.scores.row(k).transpose())));
  const ShapeModel built = buildShapeModel(trainingSet(others, shapes_.faces)),
                   left = modelWithout(shapes_, 4);
  EXPECT_LT((built.mean - left.mean).norm(), 1e-9);
  const Eigen::Index count = std::min(built.eigenvalues.size(), left.eigenvalues.size());
  EXPECT_LT((built.eigenvalues.head(count) - left.eigenvalues.head(count)).norm(),
            1e-9 * built.eigenvalues[0]);
  EXPECT_LT((built.modes * built.eigenvalues.asDiagonal() * built.modes.transpose() -
             left.modes * left.eigenvalues.asDiagonal() * left.modes.transpose())
                .norm(),
            1e-9 * built.eigenvalues.norm());
}

// Intervals hold what they promise for shapes that were left out, whatever the unit and the number
// of threads; too few shapes tell nothing.
TEST_F(ModelFitting, IsCalibratedByShapesThatAreLeftOut) {
  const double factor = fitCalibration(shapes_, pool_);
  EXPECT_GE(factor, 0.5);
  EXPECT_LE(factor, 4);
  ThreadPool one(1);
  EXPECT_EQ(fitCalibration(shapes_, one), factor);
  ShapeModel metres = shapes_;
  metres.mean /= 1000;
  metres.scores /= 1000;
  metres.eigenvalues /= 1e6;
  EXPECT_NEAR(fitCalibration(metres, pool_), factor, 0.02 * factor);
  EXPECT_EQ(fitCalibration(eggModel(4), pool_), 1);

  ModelFitParameters calibrated;
  calibrated.calibration = 2;
  const Egg other = egg({0.8, -1.1, 0.5});
  const ModelFit narrow = fit(other.mesh), wide = fit(other.mesh, calibrated);
  EXPECT_TRUE(wide.landmarks == narrow.landmarks);
  EXPECT_NEAR(wide.covariance[7].norm(), 4 * narrow.covariance[7].norm(), 1e-9);
  EXPECT_NEAR(wide.scoreDeviations[0], 2 * narrow.scoreDeviations[0], 1e-9);
}

TEST_F(ModelFitting, RefusesWhatCannotBe) {
  const Egg other = egg({0, 0, 0});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Mesh bad = other.mesh;
  bad.vertices(7, 1) = nan;
  EXPECT_THROW(target(bad), SurfaceError);
  bad = other.mesh;
  bad.faces(3, 0) = static_cast<int>(bad.vertices.rows());
  EXPECT_THROW(target(bad), SurfaceError);
  bad = other.mesh;
  bad.faces.resize(0, 3);
  EXPECT_THROW(target(bad), SurfaceError);
  bad.vertices.resize(0, 3);
  EXPECT_THROW(target(bad), SurfaceError);
  bad = other.mesh;
  bad.vertices.setConstant(3);
  EXPECT_THROW(target(bad), SurfaceError);

  ModelFitParameters parameters;
  parameters.iterations = 0;
  EXPECT_THROW(fit(other.mesh, parameters), ParameterError);
  parameters = {};
  parameters.anchors = {{shapes_.mean.rows(), Vector3::Zero(), 1}};
  EXPECT_THROW(fit(other.mesh, parameters), ParameterError);
  parameters.anchors = {{0, Vector3::Zero(), 0}};
  EXPECT_THROW(fit(other.mesh, parameters), ParameterError);
  parameters.anchors = {{0, Vector3(0, 0, nan), 1}};
  EXPECT_THROW(fit(other.mesh, parameters), ParameterError);

  bad = other.mesh;
  bad.faces.col(1).swap(bad.faces.col(2));
  EXPECT_THROW(target(bad), SurfaceError);  // inside out

  ShapeModel without = shapes_;
  without.scores.resize(0, 0);
  EXPECT_EQ(FittingModel(without, pool_).localDeviation(), assumedLocalDeviation(without));
  EXPECT_THROW(FittingModel(shapes_, pool_, {5, -1}), ParameterError);
  EXPECT_THROW(FittingModel(shapes_, pool_, {-1, 0}), ParameterError);
  without.mean.setZero();
  EXPECT_THROW(FittingModel(without, pool_), ParameterError);
}

TEST(ShapeDeviation, IsThatOfTheModelOfAllOthers) {
  const ShapeModel model = modelOf(ellipsoids(12, 4));
  const Eigen::VectorXd b = model.scores.row(2).transpose();
  const ShapeDeviation found = shapeDeviation(b, model.scores, model.eigenvalues);
  ASSERT_GT(found.modes, 0);
  ASSERT_LE(found.modes, 6);
  const Eigen::Index q = found.modes;
  // By the definition, for one of them.
  Eigen::MatrixXd others(11, q);
  for (Eigen::Index k = 0, row = 0; k < 12; ++k)
    if (k != 5) others.row(row++) = model.scores.row(k).head(q);
  const Eigen::RowVectorXd mean = others.colwise().mean();
  const Eigen::MatrixXd centred = others.rowwise() - mean;
  const Eigen::MatrixXd covariance = centred.transpose() * centred / 10;
  const Eigen::RowVectorXd d = model.scores.row(5).head(q) - mean;
  EXPECT_NEAR(found.training[5],
              std::sqrt((d * covariance.inverse()).dot(d) / static_cast<double>(q)), 1e-9);
  EXPECT_GE(found.percentile, 0);
  EXPECT_LE(found.percentile, 1);
  EXPECT_EQ(shapeDeviation(100 * b, model.scores, model.eigenvalues).percentile, 1);
  EXPECT_EQ(shapeDeviation(0 * b, model.scores, model.eigenvalues).percentile, 0);
  EXPECT_TRUE(std::isnan(shapeDeviation(b, model.scores.topRows(3), model.eigenvalues).percentile));
}

}  // namespace
}  // namespace sphere_propagation::test
