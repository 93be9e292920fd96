// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/registration/shape_alignment.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/core/test_meshes.h"

namespace sphere_propagation {
namespace {

using test::Mesh;

/// A shape without symmetry: an ellipsoid with a bump beside each of two axes.
Mesh bumpy(int frequency, unsigned seed) {
  Mesh mesh = test::transformed(test::icosphereMesh(frequency), test::randomRotation(seed), 1,
                                Vector3::Zero());
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    const Vector3 d = mesh.vertices.row(v).transpose();
    const double bumps = 0.5 * std::exp(-4 * (d - Vector3(0.6, 0.8, 0)).squaredNorm()) +
                         0.3 * std::exp(-6 * (d - Vector3(0, 0.6, 0.8)).squaredNorm());
    mesh.vertices.row(v) *= 1 + bumps;
  }
  mesh.vertices *= Vector3(30, 22, 16).asDiagonal();
  return mesh;
}

TEST(ShapeAlignment, FindsAnyPose) {
  const Mesh mesh = bumpy(10, 1), other = bumpy(9, 2);  // the same shape on two meshes
  const PreparedSurface to(surfaceOf(mesh));
  for (unsigned seed = 0; seed < 12; ++seed) {
    const Eigen::Matrix3d rotation = test::randomRotation(100 + seed);
    const Vector3 shift(5.0 * seed, -40, 100);
    const PreparedSurface from(surfaceOf(test::transformed(other, rotation, 1, shift)));
    const RigidMotion found = motionFromAnywhere(from, to);
    EXPECT_LT((found.rotation * rotation - Eigen::Matrix3d::Identity()).norm(), 0.02) << seed;
    EXPECT_LT((found.rotation * shift + found.translation).norm(), 0.3) << seed;
    EXPECT_LT(shapeDistance(from, to, found), 0.3) << seed;
    EXPECT_NEAR(found.rotation.determinant(), 1, 1e-12);
  }
}

TEST(ShapeAlignment, FindsTheSamePoseInAnyUnit) {
  const Mesh mesh = bumpy(10, 1), other = bumpy(9, 2);
  const Eigen::Matrix3d rotation = test::randomRotation(101);
  const auto found = [&](double unit) {
    const PreparedSurface to(
        surfaceOf(test::transformed(mesh, Eigen::Matrix3d::Identity(), unit, Vector3::Zero())));
    const PreparedSurface from(
        surfaceOf(test::transformed(other, rotation, unit, unit * Vector3(5, -40, 100))));
    return motionFromAnywhere(from, to);
  };
  const RigidMotion usual = found(1);
  for (const double unit : {1e-3, 1e3, 1e4}) {
    const RigidMotion motion = found(unit);
    EXPECT_LT((motion.rotation - usual.rotation).norm(), 1e-7) << unit;
    EXPECT_LT((motion.translation / unit - usual.translation).norm(), 1e-5) << unit;
  }
}

TEST(ShapeAlignment, DistanceIsZeroOnItselfAndSymmetric) {
  const PreparedSurface a(surfaceOf(bumpy(8, 3))), b(surfaceOf(test::noisyEllipsoid(4)));
  EXPECT_LT(shapeDistance(a, a), 1e-12);
  const RigidMotion motion{test::randomRotation(5), Vector3(1, 2, 3)};
  EXPECT_NEAR(shapeDistance(a, b, motion), shapeDistance(b, a, motion.inverse()), 1e-9);
}

TEST(ShapeAlignment, KnowsTheSphereByItsArea) {
  const PreparedSurface sphere(surfaceOf(test::transformed(
      test::icosphereMesh(10), Eigen::Matrix3d::Identity(), 7, Vector3(1, 2, 3))));
  EXPECT_NEAR(sphere.radius(), 7, 0.05);
  EXPECT_LT((sphere.centre() - Vector3(1, 2, 3)).norm(), 1e-6);
  EXPECT_EQ(sphere.samples().rows(), 100);
}

TEST(ShapeAlignment, NoPoseUndoesADifferenceOfVolumes) {
  const Mesh mesh = bumpy(10, 1);
  const PreparedSurface shape(surfaceOf(mesh));
  EXPECT_NEAR(minShapeDistance(shape, shape), 0, 1e-12);
  for (double scale : {0.8, 0.95, 1.3}) {
    const PreparedSurface other(
        surfaceOf(test::transformed(mesh, test::randomRotation(3), scale, Vector3(1, 2, 3))));
    const double found = shapeDistance(other, shape, motionFromAnywhere(other, shape));
    EXPECT_LT(minShapeDistance(other, shape), found) << scale;
    EXPECT_GT(minShapeDistance(other, shape), 0.4 * found) << scale;  // it says something
    EXPECT_EQ(minShapeDistance(other, shape), minShapeDistance(shape, other));
  }
}

TEST(ShapeAlignment, MirrorImagesDoNotFit) {
  const PreparedSurface shape(surfaceOf(bumpy(10, 1))),
      mirrored(surfaceOf(test::mirrored(bumpy(10, 1))));
  EXPECT_GT(shapeDistance(mirrored, shape, motionFromAnywhere(mirrored, shape)), 0.5);
}

}  // namespace
}  // namespace sphere_propagation
