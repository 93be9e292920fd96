// SPDX-License-Identifier: GPL-3.0-only
// Surfaces that are spheres topologically, but with which nothing can be computed.

#include "vcg_ext/mesh/usable_extent.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "tests/core/test_meshes.h"

namespace sphere_propagation {
namespace {

std::optional<SurfaceError> refusal(const Points& vertices, const Triangles& faces) {
  try {
    requireUsableExtent(ClosedSurface(vertices, faces, "a surface"));
  } catch (const SurfaceError& error) {
    return error;
  }
  return std::nullopt;
}

std::optional<SurfaceError> refusalOfEllipsoid(double a, double b, double c, double shift = 0) {
  const test::Mesh mesh = test::ellipsoid(a, b, c);
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  const Points turned = (mesh.vertices * rotation.transpose()).array() + shift;
  return refusal(turned, mesh.faces);
}

TEST(UsableExtent, TakesAnyUnitOfLength) {
  for (const double unit : {1e-45, 1e-9, 1e-3, 1.0, 1e3, 1e6, 1e45})
    EXPECT_FALSE(refusalOfEllipsoid(30 * unit, 20 * unit, 10 * unit, 100 * unit)) << unit;
}

TEST(UsableExtent, TakesThinSurfaces) {
  EXPECT_FALSE(refusalOfEllipsoid(30, 20, 1e-3));
  EXPECT_FALSE(refusalOfEllipsoid(30, 1e-3, 1e-3));
  EXPECT_FALSE(refusalOfEllipsoid(30, 20, 1e-3, 1e5)) << "far from the origin";
}

TEST(UsableExtent, RefusesFlatSurfacesInAnyPosition) {
  for (const double thickness : {0.0, 1e-12, 1e-6})
    for (const double shift : {0.0, 1e3}) {
      const auto error = refusalOfEllipsoid(30, 20, thickness, shift);
      ASSERT_TRUE(error) << thickness << ", " << shift;
      EXPECT_EQ(error->fault(), Fault::Flat);
      EXPECT_NE(std::string(error->what()).find("Surface \"a surface\": it is flat"),
                std::string::npos);
    }
  // Flattened by a matrix of floats.
  const test::Mesh mesh = test::ellipsoid(30, 20, 10);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  const Eigen::Matrix3f flattening =
      (turn * Vector3(1, 1, 0).asDiagonal() * turn.transpose()).cast<float>();
  const Points vertices = mesh.vertices * flattening.cast<double>().transpose();
  const auto error = refusal(vertices, mesh.faces);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::Flat);
}

TEST(UsableExtent, RefusesWhatLeavesTheRangeOfNumbers) {
  for (const double unit : {1e-160, 1e-80, 1e80, 1e160, 1e300}) {
    const auto error = refusalOfEllipsoid(30 * unit, 20 * unit, 10 * unit);
    ASSERT_TRUE(error) << unit;
    EXPECT_EQ(error->fault(), unit > 1 ? Fault::CoordinateTooLarge : Fault::ExtentTooSmall);
  }
}

}  // namespace
}  // namespace sphere_propagation
