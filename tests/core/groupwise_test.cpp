// SPDX-License-Identifier: GPL-3.0-only
// On bodies small enough for a test, with maps whose error is known because it was made.

#include "vcg_ext/groupwise/groupwise.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "tests/core/sizes.h"
#include "tests/core/test_meshes.h"
#include "vcg_ext/area/area_restoration.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/groupwise/description_length.h"
#include "vcg_ext/groupwise/moving_landmarks.h"
#include "vcg_ext/groupwise/opened_maps.h"
#include "vcg_ext/groupwise/population_model.h"
#include "vcg_ext/groupwise/population_pose.h"
#include "vcg_ext/groupwise/sphere_fields.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/remeshing/remeshing.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation {
namespace {

using test::Mesh;
using test::sizeFor;

GroupwiseParameters sized() {
  GroupwiseParameters parameters;
  parameters.frequency = sizeFor(parameters.frequency, 4);
  return parameters;
}

/// A smooth field that turns round an axis here and flows there.
Eigen::VectorXd someField(const SphereFields& fields, unsigned seed, double speed) {
  test::Random random(seed);
  Eigen::VectorXd theta(fields.count());
  for (double& value : theta) value = random.normal();
  const Points at = icosphere(6).vertices;
  return theta * (speed / fields.at(at, theta).rowwise().norm().maxCoeff());
}

/// Egg-shaped bodies of three modes: material point u of the sphere lies at place(u).
class Family {
 public:
  explicit Family(int count, unsigned seed = 3, int frequency = sizeFor(12, 6))
      : sphere_(test::icosphereMesh(frequency)), fields_(3, 0.5) {
    test::Random random(seed);
    for (int k = 0; k < count; ++k) {
      Points body = sphere_.vertices;
      const double a = 0.05 * random.normal(), b = 0.05 * random.normal(),
                   c = 0.05 * random.normal();
      for (auto x : body.rowwise()) {
        const Vector3 u = x.transpose();
        x = (1 + 0.25 * u[0] * u[1] * u[2] + a * u[0] * u[0] + b * u[0] * u[2] + 0.2 * u[2]) *
            Eigen::RowVector3d(1.6 * u[0], 1.2 * u[1] + c * u[0] * u[0], u[2]);
      }
      bodies_.push_back(10 * body);
    }
  }

  /// With maps that know the truth, or are moved away from it, but for the first one.
  std::vector<MappedSurface> mapped(double error) const {
    std::vector<MappedSurface> all;
    for (size_t k = 0; k < bodies_.size(); ++k)
      all.emplace_back(ClosedSurface(bodies_[k], sphere_.faces),
                       error > 0 && k > 0
                           ? fields_.flow(sphere_.vertices,
                                          someField(fields_, 100 + static_cast<unsigned>(k), error))
                           : sphere_.vertices);
    return all;
  }

  /// Mean distance between landmarks of a shape and where those of another belong on it, all pairs.
  double error(const std::vector<MappedSurface>& maps) const {
    const Points u = icosphere(5).vertices;
    double sum = 0;
    std::vector<Points> places;  // where each shape's landmarks are in the material
    for (const MappedSurface& map : maps)
      places.push_back(
          remesh(MappedSurface(map.surface().withVertices(10 * sphere_.vertices), map.positions()),
                 u)
              .landmarks);
    int pairs = 0;
    for (size_t s = 0; s < maps.size(); ++s)
      for (size_t t = 0; t < s; ++t, ++pairs)
        sum += (places[s] - places[t]).rowwise().norm().mean();
    return sum / pairs;
  }

 private:
  Mesh sphere_;
  SphereFields fields_;
  std::vector<Points> bodies_;
};

std::vector<MappedSurface> mapsOf(const Groupwise& optimised) {
  std::vector<MappedSurface> maps;
  for (const GroupwiseShape& shape : optimised.shapes) maps.push_back(shape.map);
  return maps;
}

double largestAngle(const Points& a, const Points& b) {
  return (a - b).rowwise().norm().maxCoeff();
}

/// The map with one end squeezed: by a Moebius transformation, up to `most` squared.
MappedSurface squeezed(const MappedSurface& map, double most) {
  Points positions = map.positions();
  for (auto u : positions.rowwise()) {
    const double stretch = most * std::sqrt((1 - u[2]) / std::max(1 + u[2], 1e-12)),
                 z = (1 - stretch * stretch) / (1 + stretch * stretch);
    const double round = std::hypot(u[0], u[1]);
    if (round > 0) u.head<2>() *= std::sqrt(1 - z * z) / round;
    u[2] = z;
    u.normalize();
  }
  return {map.surface(), positions};
}

// ---------------------------------------------------------------- fields and flows

TEST(SphereFields, AreTangentialAndLinear) {
  const SphereFields fields(3, 0.4);
  const Points u = icosphere(4).vertices;
  const Eigen::VectorXd a = someField(fields, 1, 0.3), b = someField(fields, 2, 0.2);
  EXPECT_LT(fields.at(u, a).cwiseProduct(u).rowwise().sum().cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_LT((fields.at(u, a + 2 * b) - fields.at(u, a) - 2 * fields.at(u, b)).norm(), 1e-12);
  Points functionals(2 * u.rows(), 3);
  for (Eigen::Index i = 0; i < functionals.rows(); ++i)
    functionals.row(i) << std::sin(i), std::cos(3 * i), 1;
  const Eigen::VectorXf product = fields.rows(u, functionals) * a.cast<float>();
  const Points v = fields.at(u, a);
  for (Eigen::Index i = 0; i < product.size(); ++i)
    EXPECT_NEAR(product[i], functionals.row(i).dot(v.row(i / 2)), 1e-5);
}

TEST(SphereFields, NoFieldMovesNothing) {
  const SphereFields fields(2, 0.6);
  const Points u = icosphere(3).vertices;
  EXPECT_EQ(fields.flow(u, Eigen::VectorXd::Zero(fields.count())), u);
}

TEST(SphereFields, TheFlowOfARotationIsTheRotation) {
  const SphereFields fields(4, 0.5);
  const Points u = icosphere(5).vertices;
  const Vector3 axis = Vector3(1, 2, -1).normalized();
  Eigen::MatrixXd rows(3 * u.rows(), fields.count());
  Eigen::VectorXd wanted(3 * u.rows());
  for (Eigen::Index j = 0; j < fields.count(); ++j) {
    const Points column = fields.at(u, Eigen::VectorXd::Unit(fields.count(), j));
    rows.col(j) = Eigen::Map<const Eigen::VectorXd>(column.data(), column.size());
  }
  for (Eigen::Index i = 0; i < u.rows(); ++i)
    wanted.segment<3>(3 * i) = 0.5 * axis.cross(Vector3(u.row(i).transpose()));
  const Eigen::MatrixXd normal =
      rows.transpose() * rows + 1e-9 * Eigen::MatrixXd::Identity(rows.cols(), rows.cols());
  const Eigen::VectorXd theta = normal.ldlt().solve(rows.transpose() * wanted);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.5, axis).toRotationMatrix();
  EXPECT_LT(largestAngle(fields.flow(u, theta), u * turn.transpose()), 1e-3);
}

TEST(SphereFields, FlowsComeBackAndKeepTheSphereWhole) {
  const SphereFields fields(4, 0.3);
  const Icosphere sphere = icosphere(10);
  const Eigen::VectorXd theta = someField(fields, 5, 0.15);
  const Points there = fields.flow(sphere.vertices, theta);
  EXPECT_GT(largestAngle(there, sphere.vertices), 0.1);
  EXPECT_LT((there.rowwise().norm().array() - 1).abs().maxCoeff(), 1e-14);
  EXPECT_TRUE(certify(sphere.faces, there).valid());
  EXPECT_LT(largestAngle(fields.flow(there, theta, -1), sphere.vertices), 1e-3);
}

TEST(SphereFields, RefuseAWidthThatIsNone) {
  EXPECT_THROW(SphereFields(2, 0), ParameterError);
  EXPECT_THROW(SphereFields(0, 0.5), ParameterError);
}

// ---------------------------------------------------------------- landmarks

TEST(SurfaceLandmarks, HaveTheDerivativesOfDifferences) {
  const std::vector<MappedSurface> maps = Family(2).mapped(0.1);
  LandmarkReader reader(maps[1]);
  Points u(1, 3);
  u.row(0) = Eigen::RowVector3d(0.3, -0.5, 0.8).normalized();
  const SurfaceLandmarks at = reader.read(u);
  const Vector3 along = Vector3(u.row(0).transpose()).unitOrthogonal();
  const double h = 1e-6;
  Points there(1, 3);
  there.row(0) = (u.row(0) + h * along.transpose()).normalized();
  const Vector3 difference = (reader.read(there).points - at.points).row(0).transpose() / h;
  EXPECT_LT((at.derivatives[0] * along - difference).norm(), 1e-4 * difference.norm());
  EXPECT_NEAR(at.normals.row(0).norm(), 1, 1e-12);
}

TEST(MovingLandmarks, TheMapFollowsThem) {
  const std::vector<MappedSurface> maps = Family(2, 3, 24).mapped(0.1);
  const auto sphere = std::make_shared<const Icosphere>(icosphere(7));
  const auto fields = std::make_shared<const SphereFields>(4, 0.3);
  MovingLandmarks moving(maps[1], sphere);
  const Points before = moving.landmarks().points;
  for (unsigned i = 0; i < 3; ++i) moving.move(fields, someField(*fields, 20 + i, 0.1), 0.15);
  const FollowedMap followed = moving.map();
  EXPECT_EQ(followed.share, 1);
  EXPECT_TRUE(certify(followed.map.faces(), followed.map.positions()).valid());
  const Points read = remesh(followed.map, sphere->vertices).landmarks;
  const double moved = (moving.landmarks().points - before).rowwise().norm().mean();
  EXPECT_GT(moved, 0.5);
  EXPECT_LT((moving.landmarks().points - read).rowwise().norm().mean(), 0.03 * moved);
}

// ---------------------------------------------------------------- the population

/// Landmarks of ellipsoids, and their normals; those of shape k slid round the long axis.
struct Ellipsoids {
  explicit Ellipsoids(const std::vector<double>& slides, Eigen::Vector3d axes = {3, 2, 1.4})
      : sphere(icosphere(7)) {
    for (size_t k = 0; k < slides.size(); ++k) {
      const Eigen::Vector3d size =
          axes + 0.1 * std::sin(static_cast<double>(k)) * Eigen::Vector3d(1, 0, 0);
      const Eigen::Matrix3d turn =
          Eigen::AngleAxisd(slides[k], Vector3::UnitX()).toRotationMatrix();
      const Points u = sphere.vertices * turn.transpose();
      points.emplace_back(u * size.asDiagonal());
      normals.emplace_back((u * size.cwiseInverse().asDiagonal()).rowwise().normalized());
    }
  }
  void turn(size_t k, const Eigen::Matrix3d& by) {
    points[k] = points[k] * by.transpose();
    normals[k] = normals[k] * by.transpose();
  }
  Icosphere sphere;
  std::vector<Points> points, normals;
};

double turnBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return Eigen::AngleAxisd(a * b.transpose()).angle();
}

TEST(PopulationPose, LandmarksThatSlideAreNoTurn) {
  const Ellipsoids given({0, 0, 0.4, -0.3, 0, 0, 0, 0});
  ThreadPool pool(2);
  const PopulationPose by = poseOf(given.points, given.sphere.faces, Alignment::Rigid);
  EXPECT_GT(turnBetween(by.turns[2], by.turns[0]), 0.2);
  for (const Alignment alignment : {Alignment::Rigid, Alignment::Similarity}) {
    const PopulationPose pose =
        firstPose(given.points, given.normals, given.sphere.faces, alignment, pool);
    for (const Eigen::Matrix3d& turn : pose.turns)
      EXPECT_LT(turnBetween(turn / std::cbrt(turn.determinant()), Eigen::Matrix3d::Identity()),
                0.03);
  }
}

TEST(PopulationPose, SurfacesBringBackWhatProcrustesTurned) {
  const Ellipsoids given({0, 0, 0.4, 0, 0, 0, 0, 0});
  ThreadPool pool(1);
  PopulationPose pose = poseOf(given.points, given.sphere.faces, Alignment::Rigid);
  const double before = turnBetween(pose.turns[2], pose.turns[0]);
  for (int i = 0; i < 20; ++i)
    pose = poseBySurfaces(given.points, given.normals, given.sphere.faces, Alignment::Rigid, pose,
                          pool);
  EXPECT_LT(turnBetween(pose.turns[2], pose.turns[0]), 0.75 * before);
}

TEST(PopulationPose, ShapesThatLieAnyhowAreLaidOnEachOther) {
  Ellipsoids given({0, 0.02, 0, -0.02, 0, 0});
  std::vector<Eigen::Matrix3d> turns;
  for (size_t k = 0; k < given.points.size(); ++k) {
    turns.push_back(test::randomRotation(static_cast<unsigned>(k) + 1));
    given.turn(k, turns.back());
    given.points[k].rowwise() += Eigen::RowVector3d(5.0 * static_cast<double>(k), -3, 1);
  }
  ThreadPool pool(1);
  const PopulationPose pose =
      firstPose(given.points, given.normals, given.sphere.faces, Alignment::Rigid, pool);
  for (size_t k = 0; k < turns.size(); ++k)
    EXPECT_LT(turnBetween(pose.turns[k] * turns[k], pose.turns[0] * turns[0]), 0.03);
  EXPECT_LT(pose.variance(), 0.02);
}

TEST(PopulationPose, ASphereStaysAsItIsTurned) {
  Ellipsoids given({0, 0.3, -0.5}, {1, 1, 1});
  ThreadPool pool(1);
  const PopulationPose by = poseOf(given.points, given.sphere.faces, Alignment::Rigid),
                       pose = poseBySurfaces(given.points, given.normals, given.sphere.faces,
                                             Alignment::Rigid, by, pool);
  for (size_t k = 0; k < 3; ++k) EXPECT_LT(turnBetween(pose.turns[k], by.turns[k]), 0.03);
}

TEST(PopulationModel, ExplainsWhatSurfacesShow) {
  // What is expected explains what was seen along the normals.
  const std::vector<MappedSurface> maps = Family(6).mapped(0);
  const Icosphere sphere = icosphere(6);
  std::vector<Points> points, normals;
  for (const MappedSurface& map : maps) {
    LandmarkReader reader(map.of(map.surface().withVertices(map.surface().vertices() / 12)));
    const SurfaceLandmarks landmarks = reader.read(sphere.vertices);
    points.push_back(landmarks.points);
    normals.push_back(landmarks.normals);
  }
  const PopulationPose pose = poseOf(points, sphere.faces, Alignment::None);
  ThreadPool pool(1);
  const PopulationFit fit = fitPopulation(pose, normals, {3000, 2, 12}, pool);
  EXPECT_LT(fit.residuals.maxCoeff(), 0.2 * std::sqrt(pose.variance()));
  for (size_t k = 0; k < points.size(); ++k) {
    const Eigen::VectorXd along =
        (fit.expected[k] - pose.shapes[k]).cwiseProduct(normals[k]).rowwise().sum();
    EXPECT_NEAR(std::sqrt(along.cwiseAbs2().dot(pose.weights)),
                fit.residuals[static_cast<Eigen::Index>(k)], 1e-4);
  }
}

TEST(DescriptionLength, IsTheSumOverModesAndFallsAlongItsPull) {
  const std::vector<MappedSurface> maps = Family(5, 3, 8).mapped(0.1);
  const Icosphere sphere = icosphere(4);
  std::vector<Points> points;
  for (const MappedSurface& map : maps)
    points.push_back(LandmarkReader(map).read(sphere.vertices).points / 12);
  PopulationPose pose = poseOf(points, sphere.faces, Alignment::None);
  const DescriptionLength length = descriptionLengthOf(pose, 1e-4);
  EXPECT_LT(length.pull.rowwise().sum().cwiseAbs().maxCoeff(), 1e-6 * length.pull.norm());
  // d cost = 2 / K sum_ij pull_ij <d_i, delta_j>
  const double h = 1e-6;
  Points direction = Points::Zero(points[0].rows(), 3);
  for (Eigen::Index i = 0; i < direction.size(); ++i)
    direction.data()[i] = std::sin(static_cast<double>(7 * i));
  double slope = 0;
  for (size_t j = 0; j < points.size(); ++j)
    slope += 2.0 / 5 * length.pull(2, static_cast<Eigen::Index>(j)) *
             pose.weights.dot((pose.shapes[j] - pose.mean).cwiseProduct(direction).rowwise().sum());
  pose.shapes[2] += h * direction;
  pose.mean += h / 5 * direction;
  EXPECT_NEAR((descriptionLengthOf(pose, 1e-4).cost - length.cost) / h, slope,
              1e-2 * std::fabs(slope));
}

TEST(Groupwise, RecoversAKnownWarp) {
  const Family family(8);
  const std::vector<MappedSurface> warped = family.mapped(0.25);
  ThreadPool pool(2);
  GroupwiseParameters parameters = sized();
  parameters.alignment = Alignment::None;
  const Groupwise found = optimiseGroupwise(warped, pool, parameters);
  EXPECT_LT(family.error(mapsOf(found)), 0.5 * family.error(warped));
  EXPECT_LT(found.moves.back(), 0.3 * found.moves.front());
  ASSERT_EQ(found.shapes.size(), 8U);
  for (const GroupwiseShape& shape : found.shapes) {
    EXPECT_TRUE(certify(shape.map.faces(), shape.map.positions()).valid());
    EXPECT_GT(shape.tangentialMove, 0);
  }
}

/// A body that is none of the family: three limbs.
MappedSurface stranger() {
  const Mesh sphere = test::icosphereMesh(sizeFor(12, 6));
  Points body = sphere.vertices;
  for (auto x : body.rowwise()) {
    const double reach = x.maxCoeff();
    x *= 9 * (0.6 + std::pow(std::max(reach, 0.0), 8));
  }
  return {ClosedSurface(body, sphere.faces), sphere.vertices};
}

/// As sphere.vertices lie on it, but for the reflection: places correspond, but for side.
MappedSurface mirrored(const MappedSurface& map) {
  Points body = map.surface().vertices();
  body.col(1) *= -1;
  Triangles faces = map.faces();
  faces.col(1).swap(faces.col(2));
  Points positions = map.positions();
  positions.col(1) *= -1;
  return {ClosedSurface(body, faces), positions};
}

TEST(Groupwise, ShapesThatDoNotBelongMoveTheOthersHardly) {
  const Family family(9);
  const std::vector<MappedSurface> warped = family.mapped(0.25);
  ThreadPool pool(2);
  GroupwiseParameters parameters = sized();
  parameters.iterations = 4;
  const double alone = family.error(mapsOf(optimiseGroupwise(warped, pool, parameters)));
  std::vector<MappedSurface> all = warped;
  all.push_back(mirrored(warped[4]));
  all.push_back(stranger());
  all.push_back(stranger());
  const Groupwise found = optimiseGroupwise(all, pool, parameters);
  std::vector<MappedSurface> members = mapsOf(found);
  members.resize(warped.size(), members.front());
  EXPECT_LT(family.error(members), 1.08 * alone);
  for (size_t k = 0; k < warped.size(); ++k) EXPECT_GT(found.shapes[k].trust, 0.6) << k;
  for (const size_t k : {all.size() - 2, all.size() - 1}) EXPECT_LT(found.shapes[k].trust, 0.2);
}

TEST(Groupwise, TrustsFewShapesAndThoseOfAnyVariance) {
  if (test::underThreadSanitizer()) GTEST_SKIP() << "starts no thread";
  ThreadPool pool(1);
  GroupwiseParameters parameters = sized();
  parameters.iterations = 2;
  for (const GroupwiseShape& shape :
       optimiseGroupwise({Family(1).mapped(0)[0], stranger(), stranger()}, pool, parameters).shapes)
    EXPECT_EQ(shape.trust, 1);
  for (int seed = 1; seed <= sizeFor(2, 1); ++seed)
    for (const GroupwiseShape& shape :
         optimiseGroupwise(Family(10, static_cast<unsigned>(seed)).mapped(0.1), pool, parameters)
             .shapes)
      EXPECT_GT(shape.trust, 0.6);
  EXPECT_EQ(trustIn(1, 2), 1);
  EXPECT_DOUBLE_EQ(trustIn(3, 2), 0.5);
  EXPECT_EQ(trustIn(5, 2), 0);
  EXPECT_EQ(trustIn(0, 0), 1);
  EXPECT_EQ(trustIn(1, 0), 0);
}

/// Bodies that look the same however their material is turned about their axis, with maps that do
/// not know of it, and anchors at some of their material points.
struct BodiesOfRevolution {
  explicit BodiesOfRevolution(int count) : sphere(test::icosphereMesh(sizeFor(12, 6))) {
    for (int k = 0; k < count; ++k) {
      const double turn = 0.3 * std::sin(2.0 * k), length = 1.6 + 0.1 * std::cos(1.0 * k);
      const Eigen::Matrix3d by = Eigen::AngleAxisd(turn, Vector3::UnitX()).toRotationMatrix();
      const Points there = sphere.vertices * by.transpose(),
                   body = 10 * there * Eigen::DiagonalMatrix<double, 3>(length, 1, 1);
      maps.emplace_back(ClosedSurface(body, sphere.faces), there);
      AnchorSet set;
      for (int a = 0; a < 6; ++a)
        set["anchor " + std::to_string(a)] =
            body.row((2 * a + 1) * sphere.vertices.rows() / 12).transpose();
      anchors.push_back(set);
    }
  }

  /// Mean distance between where the landmarks of two shapes are in the material, in radii.
  double error(const std::vector<MappedSurface>& found) const {
    const Points u = icosphere(5).vertices;
    double sum = 0;
    const auto places = [&](const MappedSurface& map) {
      return remesh(MappedSurface(ClosedSurface(sphere.vertices, sphere.faces), map.positions()), u)
          .landmarks;
    };
    for (size_t k = 1; k < found.size(); ++k)
      sum += (places(found[k]) - places(found[k - 1])).rowwise().norm().mean();
    return sum / static_cast<double>(found.size() - 1);
  }

  Mesh sphere;
  std::vector<MappedSurface> maps;
  std::vector<AnchorSet> anchors;
};

TEST(Groupwise, AnchorsSayWhatSurfacesDoNotShow) {
  if (test::underSanitizer()) GTEST_SKIP() << "runs what AnchorsOfSomeShapesAlone runs";
  const BodiesOfRevolution bodies(6);
  ThreadPool pool(2);
  GroupwiseParameters parameters = sized();
  parameters.iterations = 5;
  parameters.alignment = Alignment::None;
  const double before = bodies.error(bodies.maps),
               without = bodies.error(mapsOf(optimiseGroupwise(bodies.maps, pool, parameters)));
  EXPECT_GT(without, 0.7 * before);
  parameters.anchors = bodies.anchors;
  parameters.anchors[0]["of one shape"] = Vector3(1, 2, 3);
  const Groupwise found = optimiseGroupwise(bodies.maps, pool, parameters);
  EXPECT_LT(bodies.error(mapsOf(found)), 0.5 * before);
  for (const GroupwiseShape& shape : found.shapes) {
    EXPECT_LT(shape.anchorDistance, 0.6);  // of 16
    EXPECT_TRUE(certify(shape.map.faces(), shape.map.positions()).valid());
  }
}

TEST(Groupwise, AnchorsOfSomeShapesAlone) {
  if (test::underThreadSanitizer()) GTEST_SKIP() << "starts no thread";
  const BodiesOfRevolution bodies(4);
  ThreadPool pool(1);
  GroupwiseParameters parameters = sized();
  parameters.iterations = 1;
  parameters.anchors = bodies.anchors;
  parameters.anchors[1].clear();
  const Groupwise found = optimiseGroupwise(bodies.maps, pool, parameters);
  EXPECT_GT(found.shapes[0].anchorDistance, 0);
  EXPECT_TRUE(std::isnan(found.shapes[1].anchorDistance));
  parameters.anchors.pop_back();
  EXPECT_THROW(optimiseGroupwise(bodies.maps, pool, parameters), ParameterError);
  // Names that nobody shares change nothing.
  parameters.anchors.assign(4, {});
  parameters.anchors[2]["alone"] = Vector3(0, 0, 1);
  const Groupwise alone = optimiseGroupwise(bodies.maps, pool, parameters);
  parameters.anchors.clear();
  const Groupwise none = optimiseGroupwise(bodies.maps, pool, parameters);
  for (size_t k = 0; k < 4; ++k)
    EXPECT_EQ(alone.shapes[k].map.positions(), none.shapes[k].map.positions());
}

TEST(Groupwise, LeavesRightMapsNearlyWhereTheyAre) {
  if (test::underThreadSanitizer()) GTEST_SKIP() << "starts no thread";
  const Family family(6);
  ThreadPool pool(1);
  GroupwiseParameters parameters = sized();
  parameters.alignment = Alignment::None;
  parameters.iterations = sizeFor(parameters.iterations, 3);
  const double spread = family.error(family.mapped(0.25));
  EXPECT_LT(family.error(mapsOf(optimiseGroupwise(family.mapped(0), pool, parameters))),
            0.35 * spread);
}

TEST(OpenedMaps, OnlyWhatIsSqueezedMoves) {
  std::vector<MappedSurface> maps = Family(6).mapped(0);
  maps[2] = squeezed(maps[2], 4);
  ThreadPool pool(2);
  const std::vector<OpenedMap> opened = openedMaps(maps, pool);
  ASSERT_EQ(opened.size(), maps.size());
  for (size_t k = 0; k < maps.size(); ++k) {
    EXPECT_EQ(opened[k].squeezed > 0, k == 2);
    EXPECT_EQ(opened[k].map.positions() == maps[k].positions(), k != 2);
    EXPECT_TRUE(certify(opened[k].map.faces(), opened[k].map.positions()).valid());
  }
  EXPECT_GT(opened[2].squeezed, 0.15);
  // All of it came back: it is again near where it was.
  EXPECT_LT(largestAngle(opened[2].map.positions(), maps[0].positions()),
            0.5 * largestAngle(maps[2].positions(), maps[0].positions()));
}

TEST(OpenedMaps, WhatAllMapsSqueezeIsNoLoss) {
  std::vector<MappedSurface> maps = Family(4).mapped(0);
  for (MappedSurface& map : maps) map = squeezed(map, 3);
  ThreadPool pool(1);
  const std::vector<OpenedMap> opened = openedMaps(maps, pool);
  for (size_t k = 0; k < maps.size(); ++k)
    EXPECT_LT(opened[k].squeezed, 0.3 * squeezedShare(maps[k], 3));
}

TEST(PopulationPose, ShapesAreLaidOnTheMeanToSayHowFarTheyAre) {
  const Mesh sphere = test::icosphereMesh(4);
  Points body = sphere.vertices * Eigen::DiagonalMatrix<double, 3>(3, 2, 1);
  const PopulationPose pose = poseOf({body, body}, sphere.faces, Alignment::None);
  const Points normals = vertexNormals(body, sphere.faces);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  const Points turned = (body * turn.transpose()).rowwise() + Eigen::RowVector3d(4, 5, 6),
               turnedNormals = normals * turn.transpose();
  EXPECT_LT(distanceAlongNormals(pose, turned, turnedNormals, Alignment::Rigid), 1e-12);
  EXPECT_GT(distanceAlongNormals(pose, turned, turnedNormals, Alignment::None), 1);
  EXPECT_LT(distanceAlongNormals(pose, 2 * turned, turnedNormals, Alignment::Similarity), 1e-12);
  EXPECT_GT(distanceAlongNormals(pose, 2 * turned, turnedNormals, Alignment::Rigid), 0.5);
  EXPECT_NEAR(distanceAlongNormals(pose, body + 0.1 * normals, normals, Alignment::None), 0.1,
              1e-12);
}

TEST(Groupwise, FindsWhatPropagationSqueezed) {
  if (test::underSanitizer()) GTEST_SKIP() << "runs what others run";
  const Family family(8);
  std::vector<MappedSurface> maps = family.mapped(0.1);
  for (const size_t k : {2, 5}) maps[k] = squeezed(maps[k], 10);
  ThreadPool pool(1);
  GroupwiseParameters parameters = sized();
  parameters.alignment = Alignment::None;
  const Groupwise found = optimiseGroupwise(maps, pool, parameters);
  EXPECT_LT(family.error(mapsOf(found)), 0.3 * family.error(maps));
  EXPECT_GT(found.shapes[2].squeezed, 0.15);
  EXPECT_EQ(found.shapes[0].squeezed, 0);
}

TEST(Groupwise, AreasThatDifferBecauseShapesDoAreNotOpened) {
  if (test::underSanitizer()) GTEST_SKIP() << "runs what others run";
  // A limb that is long on some shapes: the right maps give it little of the sphere.
  const Mesh sphere = test::icosphereMesh(16);
  const Vector3 tip = Vector3(1, 2, -1).normalized();
  std::vector<MappedSurface> maps;
  for (int k = 0; k < 8; ++k) {
    const double length = k % 3 == 2 ? 3 : 0.4 + 0.1 * std::sin(k);
    Points body = sphere.vertices;
    for (auto x : body.rowwise()) {
      const double near = std::exp((x.dot(tip.transpose()) - 1) / 0.05);
      x = (1 + 0.15 * x[0] * x[1] + length * near) * Eigen::RowVector3d(1.5 * x[0], x[1], x[2]);
    }
    maps.emplace_back(ClosedSurface(10 * body, sphere.faces), sphere.vertices);
  }
  maps[0] = squeezed(maps[0], 10);  // where something was lost
  ThreadPool pool(1);
  const std::vector<OpenedMap> opened = openedMaps(maps, pool);
  GroupwiseParameters parameters = sized();
  parameters.alignment = Alignment::None;
  parameters.iterations = 1;
  const Groupwise found = optimiseGroupwise(maps, pool, parameters);
  for (const size_t k : {2, 5}) {
    EXPECT_GT(opened[k].squeezed, 0.02) << k;
    EXPECT_GT(largestAngle(opened[k].map.positions(), maps[k].positions()), 0.3) << k;
    EXPECT_EQ(found.shapes[k].squeezed, 0) << k;
  }
  EXPECT_GT(found.shapes[0].squeezed, 0.15);
}

TEST(Groupwise, ShapesThatAgreeStayAsTheyAre) {
  const MappedSurface one = Family(1).mapped(0).front();
  ThreadPool pool(1);
  const Groupwise found = optimiseGroupwise({one, one, one}, pool, sized());
  for (const GroupwiseShape& shape : found.shapes)
    EXPECT_LT(largestAngle(shape.map.positions(), one.positions()), 1e-9);
  EXPECT_NEAR(found.varianceAfter, 0, 1e-20);
}

TEST(Groupwise, TurnsAndScalesWithTheShapes) {
  if (test::underThreadSanitizer()) GTEST_SKIP() << "starts no thread";
  const std::vector<MappedSurface> given = Family(4).mapped(0.2);
  std::vector<MappedSurface> moved;
  const Eigen::Matrix3d turn = test::randomRotation(4);
  for (const MappedSurface& map : given)
    moved.push_back(map.of(
        map.surface().withVertices((1000 * map.surface().vertices() * turn.transpose()).rowwise() +
                                   Eigen::RowVector3d(5000, -100, 7))));
  ThreadPool pool(1);
  GroupwiseParameters parameters = sized();
  parameters.iterations = 3;
  const Groupwise a = optimiseGroupwise(given, pool, parameters),
                  b = optimiseGroupwise(moved, pool, parameters);
  for (size_t k = 0; k < given.size(); ++k) {
    EXPECT_LT(largestAngle(a.shapes[k].map.positions(), b.shapes[k].map.positions()), 2e-3);
    EXPECT_NEAR(b.shapes[k].tangentialMove, 1000 * a.shapes[k].tangentialMove,
                10 * a.shapes[k].tangentialMove);
  }
}

TEST(Groupwise, IsTheSameWithAnyNumberOfThreads) {
  const std::vector<MappedSurface> given = Family(4).mapped(0.2);
  for (const auto objective :
       {GroupwiseObjective::PopulationModel, GroupwiseObjective::DescriptionLength}) {
    GroupwiseParameters parameters = sized();
    parameters.objective = objective;
    parameters.iterations = sizeFor(3, 2);
    ThreadPool one(1), three(3);
    const Groupwise b = optimiseGroupwise(given, three, parameters);
    if (test::underSanitizer()) continue;  // a second run meets what the first did
    const Groupwise a = optimiseGroupwise(given, one, parameters);
    for (size_t k = 0; k < given.size(); ++k)
      EXPECT_EQ(a.shapes[k].map.positions(), b.shapes[k].map.positions());
    EXPECT_EQ(a.moves, b.moves);
  }
}

TEST(Groupwise, TheDescriptionLengthFalls) {
  if (test::underThreadSanitizer()) GTEST_SKIP() << "starts no thread";
  ThreadPool pool(1);
  GroupwiseParameters parameters = sized();
  parameters.objective = GroupwiseObjective::DescriptionLength;
  const Groupwise found = optimiseGroupwise(Family(5).mapped(0.2), pool, parameters);
  ASSERT_EQ(found.costs.size(), 9U);
  EXPECT_LT(found.costs.back(), found.costs.front());
  EXPECT_EQ(found.surfacePrecision, 0);
}

TEST(Groupwise, RefusesWhatIsOutOfRange) {
  const std::vector<MappedSurface> two = Family(2).mapped(0);
  ThreadPool pool(1);
  EXPECT_THROW(optimiseGroupwise({two[0]}, pool), ParameterError);
  const auto refused = [&](auto change) {
    GroupwiseParameters parameters;
    change(parameters);
    EXPECT_THROW(optimiseGroupwise(two, pool, parameters), ParameterError);
  };
  refused([](GroupwiseParameters& p) { p.iterations = 0; });
  refused([](GroupwiseParameters& p) { p.surfacePrecision = -1; });
  refused([](GroupwiseParameters& p) { p.surfacePrecision = std::nan(""); });
  refused([](GroupwiseParameters& p) { p.priorShapes = 0; });
  refused([](GroupwiseParameters& p) { p.anchorDeviation = -1; });
  refused([](GroupwiseParameters& p) { p.frequency = 2; });
  refused([](GroupwiseParameters& p) { p.frequency = 31; });
}

}  // namespace
}  // namespace sphere_propagation
