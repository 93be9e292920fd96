// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/registration/rigid_alignment.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/core/test_meshes.h"
#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

RigidMotion turn(double degrees, const Vector3& axis, const Vector3& translation) {
  return {Eigen::AngleAxisd(degrees * std::acos(-1.0) / 180, axis.normalized()).toRotationMatrix(),
          translation};
}

double difference(const RigidMotion& a, const RigidMotion& b) {
  return (a.rotation - b.rotation).norm() + (a.translation - b.translation).norm();
}

TEST(RigidMotion, AppliesOneAfterTheOtherAndBack) {
  const RigidMotion a = turn(50, {1, 2, 3}, {4, 5, -6}), b = turn(-20, {0, 1, 3}, {1, 0, 2});
  const Points points = test::octahedron().vertices;
  EXPECT_LT(test::largestDistance((a * b).applyTo(points), a.applyTo(b.applyTo(points))), 1e-12);
  EXPECT_LT(test::largestDistance(a.inverse().applyTo(a.applyTo(points)), points), 1e-12);
  EXPECT_TRUE(RigidMotion().isIdentity());
  EXPECT_FALSE(a.isIdentity());
}

TEST(FitRigid, RecoversAnyMotion) {
  const Points points = test::noisyEllipsoid(1).vertices;
  for (unsigned seed = 0; seed < 10; ++seed) {
    const RigidMotion motion{test::randomRotation(seed), Vector3(10, -20, seed)};
    EXPECT_LT(difference(fitRigid(points, motion.applyTo(points)), motion), 1e-11);
  }
}

TEST(FitRigid, IsTheLeastSquaresFit) {
  const Points from = test::noisyEllipsoid(2).vertices, to = test::noisyEllipsoid(3).vertices;
  const RigidMotion best = fitRigid(from, to);
  const double least = (best.applyTo(from) - to).squaredNorm();
  test::Random random(4);
  for (int i = 0; i < 50; ++i) {
    RigidMotion other = turn(random.uniform(0.01, 2), random.direction(),
                             best.translation + 0.01 * random.direction());
    other.rotation = other.rotation * best.rotation;
    EXPECT_GT((other.applyTo(from) - to).squaredNorm(), least);
  }
}

TEST(FitRigid, DoesNotReflect) {
  const Points from = test::noisyEllipsoid(5).vertices;
  Points mirrored = from;
  mirrored.col(0) *= -1;
  EXPECT_NEAR(fitRigid(from, mirrored).rotation.determinant(), 1, 1e-12);
  Points flat = from;
  flat.col(2).setZero();  // either handedness fits: it must be the proper one
  const RigidMotion motion = turn(40, {1, 2, 3}, {1, 1, 1});
  EXPECT_LT(difference(fitRigid(flat, motion.applyTo(flat)), motion), 1e-10);
}

TEST(FitRigid, RefusesWhatIsNotPaired) {
  EXPECT_THROW(fitRigid(Points::Zero(3, 3), Points::Zero(4, 3)), ParameterError);
  EXPECT_THROW(fitRigid(Points(0, 3), Points(0, 3)), ParameterError);
}

TEST(AlignRigidly, RecoversASmallMotionOfTheSameMesh) {
  const Points reference = test::noisyEllipsoid(6).vertices;
  const VertexLocator locator(reference);
  const RigidMotion away = turn(3, {1, -2, 1}, {0.5, -0.3, 0.4});
  const RigidAlignment found = alignRigidly(away.applyTo(reference), locator);
  EXPECT_TRUE(found.converged);
  EXPECT_LT(found.iterations, 30);
  EXPECT_GT(found.iterations, 1);  // the first pairs are not yet right: this is more than one fit
  EXPECT_LT((found.motion.applyTo(away.applyTo(reference)) - reference).cwiseAbs().maxCoeff(),
            1e-10);
}

TEST(AlignRigidly, StopsWhenNothingChanges) {
  const Points reference = test::noisyEllipsoid(7).vertices;
  const RigidAlignment found = alignRigidly(reference, VertexLocator(reference));
  EXPECT_TRUE(found.converged);
  EXPECT_EQ(found.iterations, 1);
  EXPECT_LT(difference(found.motion, RigidMotion{}), 1e-12);
}

TEST(AlignRigidly, StopsAfterTheGivenIterations) {
  const Points reference = test::noisyEllipsoid(8).vertices;
  const VertexLocator locator(reference);
  const Points moved = turn(15, {1, 1, 0}, {2, 0, 0}).applyTo(reference);
  const RigidAlignment none = alignRigidly(moved, locator, 0),
                       one = alignRigidly(moved, locator, 1);
  EXPECT_EQ(none.iterations, 0);
  EXPECT_EQ(difference(none.motion, RigidMotion{}), 0);
  EXPECT_EQ(one.iterations, 1);
  EXPECT_FALSE(one.converged);
  // One iteration by its definition: nearest points, one fit.
  const std::vector<int> pairs = locator.nearest(moved);
  Points targets(moved.rows(), 3);
  for (size_t i = 0; i < pairs.size(); ++i)
    targets.row(static_cast<Eigen::Index>(i)) = reference.row(pairs[i]);
  EXPECT_LT(difference(one.motion, fitRigid(moved, targets)), 1e-14);
  EXPECT_THROW(alignRigidly(moved, locator, -1), ParameterError);
  EXPECT_THROW(alignRigidly(Points(0, 3), locator), ParameterError);
}

}  // namespace
}  // namespace sphere_propagation
