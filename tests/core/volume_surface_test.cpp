// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/volume_surface.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "tests/core/label_shapes.h"
#include "tests/core/sizes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

using test::labelsOf;

VolumeSurface surfaceOf(const LabelGrid& labels, double voxelSize = 0) {
  VolumeSurfaceParameters parameters;
  parameters.interpolation.voxelSize = voxelSize;
  return volumeSurface(labels, parameters);
}

/// Throws what is wrong with the surface as a sphere.
void requireSphere(const VolumeSurface& surface) {
  const ClosedSurface sphere(surface.vertices, surface.faces);
}

/// Twice the inscribed circle's radius over that of the circumscribed one: 1 when equilateral, 0
/// without area.
Eigen::VectorXd triangleShapes(const VolumeSurface& surface) {
  const Points angles = cornerAngles(surface.vertices, surface.faces);
  return (angles.array().cos().rowwise().sum() - 1) * 2;
}

TEST(LabelGrid, ChecksItself) {
  const LabelGrid good = labelsOf(test::ball(2), {5, 5, 5});
  EXPECT_NO_THROW(good.check());
  LabelGrid bad = good;
  bad.size[2] = 0;
  EXPECT_THROW(bad.check(), VolumeError);
  bad = good;
  bad.values.pop_back();
  EXPECT_THROW(bad.check(), VolumeError);
  bad = good;
  bad.toWorld(1, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(bad.check(), VolumeError);
  bad = good;
  bad.toWorld.col(1) = bad.toWorld.col(0);
  EXPECT_THROW(bad.check(), VolumeError);
  EXPECT_THROW(volumeSurface(bad), VolumeError);
  bad = good;
  bad.toWorld(3, 0) = 1;
  EXPECT_THROW(bad.check(), VolumeError);
}

TEST(LabelGrid, CountsLabelsAndMeasuresVoxels) {
  LabelGrid grid = labelsOf([](const Vector3&) { return false; }, {2, 2, 2}, {1, 2, 3});
  grid.values = {0, 3, 3, 0, 0, -1, 3, 0};
  EXPECT_EQ(grid.count(), (std::map<std::int32_t, long>{{-1, 1}, {3, 3}}));
  EXPECT_NEAR(grid.voxelVolume(), 6, 1e-12);
  grid.toWorld.topLeftCorner<3, 3>() = test::randomRotation(1) * grid.toWorld.topLeftCorner<3, 3>();
  grid.toWorld.col(0) *= -1;
  EXPECT_NEAR(grid.voxelVolume(), 6, 1e-12);
  EXPECT_NEAR((grid.spacing() - Vector3(1, 2, 3)).norm(), 0, 1e-12);
}

TEST(VolumeSurface, KeepsTheVolumeOfTheLabels) {
  for (const double radius : {3.0, 6.0, 12.0}) {
    const int n = 2 * static_cast<int>(radius) + 3;
    const VolumeSurface surface =
        surfaceOf(labelsOf(test::ball(radius, {0.2, 0.3, -0.1}), {n, n, n}, {0.8, 0.8, 0.8}));
    requireSphere(surface);
    EXPECT_NEAR(surface.volume / surface.labelVolume, 1, 0.01);
  }
  for (const auto& shape : {test::thickCup(6, 10), test::thickCup(8.5, 10)}) {
    const VolumeSurface surface = surfaceOf(labelsOf(shape, {25, 25, 25}));
    requireSphere(surface);
    EXPECT_NEAR(surface.volume / surface.labelVolume, 1, 0.01);
    EXPECT_EQ(surface.handles.changedVoxels, 0);
  }
}

TEST(VolumeSurface, OfABallIsRoundWithTrianglesOfDecentShape) {
  const double radius = 12;
  const VolumeSurface surface = surfaceOf(labelsOf(test::ball(radius), {29, 29, 29}));
  const Eigen::ArrayXd off = surface.vertices.rowwise().norm().array() - radius;
  EXPECT_LT(std::sqrt(off.square().mean()), 0.1);
  EXPECT_LT(off.abs().maxCoeff(), 0.5);  // the voxels at the poles end half a voxel short
  const Eigen::VectorXd shapes = triangleShapes(surface);
  EXPECT_GT(shapes.mean(), 0.85);
  EXPECT_LT((shapes.array() < 0.3).cast<double>().mean(), 0.01);
  // The faces look outwards: no folds.
  const Points normals = faceNormals(surface.vertices, surface.faces);
  for (Eigen::Index f = 0; f < surface.faces.rows(); ++f)
    ASSERT_GT(normals.row(f).dot(surface.vertices.row(surface.faces(f, 0)).normalized()), 0.7);
}

TEST(VolumeSurface, VertexCountFollowsTheVoxelSize) {
  const LabelGrid labels = labelsOf(test::ball(12), {29, 29, 29});
  const VolumeSurface fine = surfaceOf(labels, 0.7), own = surfaceOf(labels),
                      coarse = surfaceOf(labels, 2);
  EXPECT_EQ(own.voxelSize, 1);
  EXPECT_NEAR(
      static_cast<double>(own.vertices.rows()) / static_cast<double>(coarse.vertices.rows()), 4,
      0.6);
  EXPECT_NEAR(static_cast<double>(fine.vertices.rows()) / static_cast<double>(own.vertices.rows()),
              1 / 0.49, 0.3);
  for (const VolumeSurface& surface : {fine, own, coarse}) {
    requireSphere(surface);
    EXPECT_NEAR(surface.volume / surface.labelVolume, 1, 0.015);
  }
}

TEST(VolumeSurface, OfSlicesFarApartIsSmoothBetweenThem) {
  // An ellipsoid with slices of 10 mm: its own equator, not terraces.
  const Vector3 axes(25, 25, 45);
  const auto inside = [&](const Vector3& x) { return x.cwiseQuotient(axes).norm() < 1; };
  const VolumeSurface surface = surfaceOf(labelsOf(inside, {45, 45, 12}, {1.4, 1.4, 10}));
  requireSphere(surface);
  EXPECT_EQ(surface.voxelSize, 1.4);
  EXPECT_NEAR(surface.volume / surface.labelVolume, 1, 0.03);
  Eigen::ArrayXd off(surface.vertices.rows());
  Eigen::Index used = 0;
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v) {
    const Vector3 x = surface.vertices.row(v).transpose();
    if (std::fabs(x[2]) > 33) continue;  // the caps are as flat as the slices say
    off[used++] = (x.cwiseQuotient(axes).norm() - 1) * 25;
  }
  EXPECT_LT(std::sqrt(off.head(used).square().mean()), 0.4);
  EXPECT_LT(off.head(used).abs().maxCoeff(), 1.4);
}

TEST(VolumeSurface, ClosesHalfASliceBeyondTheLastOnes) {
  const auto cylinder = [](const Vector3& x) {
    return x.head<2>().norm() < 15 && std::fabs(x[2]) < 21;
  };
  const LabelGrid labels = labelsOf(cylinder, {35, 35, 7}, {1, 1, 10});  // slices at -20, -10 .. 20
  VolumeSurfaceParameters parameters;
  parameters.smoothing = 0;
  const VolumeSurface surface = volumeSurface(labels, parameters);
  requireSphere(surface);
  EXPECT_NEAR(surface.vertices.col(2).maxCoeff(), 25, 0.3);
  EXPECT_NEAR(surface.vertices.col(2).minCoeff(), -25, 0.3);
  EXPECT_NEAR(surface.volume / surface.labelVolume, 1, 0.01);
}

TEST(VolumeSurface, KeepsAWallThatSlipsFartherThanItIsThick) {
  // A funnel with a bottom: 6 mm thick in its slices, 9 mm wider from one to the next.
  const auto funnel = [](const Vector3& x) {
    const double outer = 30 + 0.9 * x[2], r = x.head<2>().norm();
    return r < outer && (r > outer - 6 || x[2] < -20);
  };
  const VolumeSurface surface = surfaceOf(labelsOf(funnel, {76, 76, 6}, {1.5, 1.5, 10}));
  requireSphere(surface);
  EXPECT_EQ(surface.handles.handles, 0);
  EXPECT_EQ(surface.dropped.parts, 0);
  EXPECT_NEAR(surface.volume / surface.labelVolume, 1, 0.03);
  long between = 0;  // the vertices half way between slices lie on the cones, as at the slices
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v) {
    const double z = surface.vertices(v, 2), r = surface.vertices.row(v).head<2>().norm(),
                 outer = 30 + 0.9 * z;
    if (z < -14 || z > 24) continue;
    ++between;
    EXPECT_LT(std::min(std::fabs(r - outer), std::fabs(r - outer + 6)), 1.5)
        << surface.vertices.row(v);
  }
  EXPECT_GT(between, 1000);
}

TEST(VolumeSurface, PutsNoLidOnAWallThatOpensToTheSide) {
  const auto notched = [](const Vector3& x) {
    const double r = x.head<2>().norm();
    if (x[2] > 0 && x[0] > 0 && std::fabs(x[1]) < 8) return false;
    return r < 20 && (r > 14 || x[2] < -20);
  };
  const VolumeSurface surface = surfaceOf(labelsOf(notched, {35, 35, 6}, {1.5, 1.5, 10}));
  requireSphere(surface);
  EXPECT_EQ(surface.handles.handles, 0);
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
    EXPECT_TRUE(surface.vertices(v, 2) < -15 || surface.vertices.row(v).head<2>().norm() > 11);
}

TEST(VolumeSurface, InterpolatesMissingSlicesAndCountsThem) {
  for (const double slice : {1.0, 4.0}) {
    const auto cone = [](const Vector3& x) {
      return x.head<2>().norm() < 12 - 0.2 * x[2] && std::fabs(x[2]) < 17;
    };
    const LabelGrid whole =
        labelsOf(cone, {39, 39, static_cast<int>(36 / slice) + 1}, {1, 1, slice});
    LabelGrid gappy = whole;
    const int middle = whole.size[2] / 2;
    std::fill(gappy.values.begin() + static_cast<std::ptrdiff_t>(gappy.index(0, 0, middle)),
              gappy.values.begin() + static_cast<std::ptrdiff_t>(gappy.index(0, 0, middle + 2)), 0);
    const VolumeSurface full = surfaceOf(whole), filled = surfaceOf(gappy);
    requireSphere(filled);
    EXPECT_EQ(full.interpolatedSlices, 0);
    EXPECT_EQ(filled.interpolatedSlices, 2);
    EXPECT_EQ(filled.dropped.parts, 0);
    EXPECT_NEAR(filled.volume / full.volume, 1, 0.01);
    VolumeSurfaceParameters parameters;
    parameters.interpolation.longestGap = 1;
    EXPECT_EQ(volumeSurface(gappy, parameters).dropped.parts, 1);
  }
}

TEST(VolumeSurface, BridgesNoGapToASpeck) {
  LabelGrid labels = labelsOf(test::ball(6), {20, 20, 24});
  labels.values[labels.index(10, 10, 21)] = 1;
  const VolumeSurface surface = surfaceOf(labels);
  EXPECT_EQ(surface.interpolatedSlices, 0);
  EXPECT_EQ(surface.dropped.parts, 1);
  EXPECT_EQ(surface.dropped.voxels, 1);
  EXPECT_LT(surface.vertices.col(2).maxCoeff(), 7);
}

TEST(VolumeSurface, LiesWhereTheMatrixPutsIt) {
  // The same shape in any order of axes, turned, mirrored, sheared: the same surface, outward.
  const auto shape = [](const Vector3& x) {
    return x.cwiseQuotient(Vector3(10, 7, 5)).norm() < 1 && x[0] < 6;
  };
  const LabelGrid plain = labelsOf(shape, {25, 19, 15});
  const VolumeSurface reference = surfaceOf(plain);
  Eigen::Matrix4d moved = Eigen::Matrix4d::Identity();
  moved.topLeftCorner<3, 3>() = test::randomRotation(5);
  moved.topRightCorner<3, 1>() = Vector3(40, -30, 200);
  Eigen::Matrix4d mirrored = moved;
  mirrored.col(1) *= -1;
  Eigen::Matrix4d sheared = moved;
  sheared.col(2) += 0.3 * sheared.col(0);
  sheared.col(2).head<3>().normalize();
  for (const Eigen::Matrix4d& matrix : {moved, mirrored, sheared}) {
    LabelGrid grid = plain;
    grid.toWorld = matrix * plain.toWorld;
    const VolumeSurface surface = surfaceOf(grid);
    requireSphere(surface);
    EXPECT_GT(surface.volume, 0);
    EXPECT_NEAR(surface.volume / surface.labelVolume, 1, 0.01);
    const Points meant = (reference.vertices * matrix.topLeftCorner<3, 3>().transpose()).rowwise() +
                         matrix.topRightCorner<3, 1>().transpose();
    ASSERT_EQ(surface.vertices.rows(), meant.rows());
    EXPECT_LT((surface.vertices - meant).rowwise().norm().maxCoeff(), 1e-3);
  }
  LabelGrid permuted;  // axes k, i, j
  permuted.size = {plain.size[2], plain.size[0], plain.size[1]};
  permuted.toWorld.col(0) = plain.toWorld.col(2);
  permuted.toWorld.col(1) = plain.toWorld.col(0);
  permuted.toWorld.col(2) = plain.toWorld.col(1);
  permuted.toWorld.col(3) = plain.toWorld.col(3);
  for (int j = 0; j < plain.size[1]; ++j)
    for (int i = 0; i < plain.size[0]; ++i)
      for (int k = 0; k < plain.size[2]; ++k)
        permuted.values.push_back(plain.values[plain.index(i, j, k)]);
  const VolumeSurface surface = surfaceOf(permuted);
  requireSphere(surface);
  EXPECT_NEAR(surface.volume, reference.volume, 1e-2 * reference.volume);
  EXPECT_NEAR(
      (surface.vertices.colwise().maxCoeff() - reference.vertices.colwise().maxCoeff()).norm(), 0,
      0.05);
  EXPECT_NEAR(
      (surface.vertices.colwise().minCoeff() - reference.vertices.colwise().minCoeff()).norm(), 0,
      0.05);
}

TEST(VolumeSurface, OfATorusIsASphereAndOnRequestATorus) {
  const LabelGrid labels = labelsOf(test::solidTorus(11, 3), {33, 33, 11});
  const VolumeSurface cut = surfaceOf(labels);
  requireSphere(cut);
  EXPECT_EQ(cut.handles.handles, 1);
  EXPECT_GT(cut.handles.changedVoxels, 0);
  EXPECT_LT(static_cast<double>(cut.handles.changedVoxels),
            0.03 * static_cast<double>(cut.workingVoxels));
  VolumeSurfaceParameters parameters;
  parameters.cutHandles = false;
  const VolumeSurface torus = volumeSurface(labels, parameters);
  EXPECT_EQ(torus.vertices.rows() - torus.faces.rows() / 2, 0);
  EXPECT_NEAR(torus.volume / torus.labelVolume, 1, 0.01);
}

TEST(VolumeSurface, IsASphereWhateverTheLabels) {
  const auto step = static_cast<unsigned>(test::sizeFor(1, 5));
  for (unsigned seed = 0; seed < 21; seed += step) {
    LabelGrid labels = test::randomBlobs(seed, {20, 21, 22}, seed % 4 * 0.7, seed % 5 * 0.05);
    if (seed % 3 == 1) labels.toWorld(2, 2) = 4;
    for (const double smoothing : {0.0, 1.0, 2.5}) {
      VolumeSurfaceParameters parameters;
      parameters.smoothing = smoothing;
      if (seed % 3 == 2) parameters.interpolation.voxelSize = 0.8;
      ASSERT_NO_THROW(requireSphere(volumeSurface(labels, parameters)))
          << "seed " << seed << ", smoothing " << smoothing;
    }
  }
}

TEST(VolumeSurface, BearsTheThinnestLabels) {
  const auto sheet = [](const Vector3& x) {
    return std::fabs(x[2]) < 0.5 && x.head<2>().norm() < 8;
  };
  const VolumeSurface flat = surfaceOf(labelsOf(sheet, {21, 21, 7}));
  requireSphere(flat);
  EXPECT_GT(flat.vertices.col(0).maxCoeff(), 6);  // still the whole sheet
  requireSphere(surfaceOf(labelsOf(test::ball(0.5), {3, 3, 3})));
  requireSphere(surfaceOf(labelsOf([](const Vector3&) { return true; }, {1, 1, 1})));
  requireSphere(surfaceOf(labelsOf([](const Vector3&) { return true; }, {5, 4, 1}, {1, 1, 8})));
  const VolumeSurface box =
      surfaceOf(labelsOf([](const Vector3&) { return true; }, {9, 8, 7}));  // up to the border
  requireSphere(box);
  EXPECT_NEAR(box.volume / 504, 1, 0.01);
}

TEST(VolumeSurface, UnitesLabels) {
  LabelGrid labels = labelsOf(test::ball(8), {21, 21, 21});
  const VolumeSurface whole = surfaceOf(labels);
  for (int k = 0; k < 10; ++k)
    for (int j = 0; j < 21; ++j)
      for (int i = 0; i < 21; ++i) labels.values[labels.index(i, j, k)] *= 7;
  VolumeSurfaceParameters parameters;
  parameters.interpolation.labels = {7, 1};
  EXPECT_EQ(volumeSurface(labels, parameters).vertices, whole.vertices);
  parameters.interpolation.labels = {7};
  EXPECT_LT(volumeSurface(labels, parameters).labelVolume, 0.5 * whole.labelVolume);
}

TEST(VolumeSurface, FillsAndDropsAsAskedFor) {
  const auto shape = [](const Vector3& x) {
    return (x.norm() < 7 && x.norm() > 2.5) || (x - Vector3(0, 0, 10)).norm() < 1.5;
  };
  const LabelGrid labels = labelsOf(shape, {19, 19, 25});
  const VolumeSurface good = surfaceOf(labels);
  requireSphere(good);
  EXPECT_GT(good.filledVoxels, 40);
  EXPECT_EQ(good.dropped.parts, 1);
  VolumeSurfaceParameters parameters;
  parameters.fillHoles = parameters.keepLargestComponent = parameters.cutHandles = false;
  const VolumeSurface raw = volumeSurface(labels, parameters);
  EXPECT_EQ(raw.vertices.rows() - raw.faces.rows() / 2, 6);  // three spheres: ball, cavity, speck
  EXPECT_EQ(raw.filledVoxels + raw.dropped.parts + raw.handles.changedVoxels, 0);
}

TEST(VolumeSurface, SaysWhichLabelsThereAre) {
  const LabelGrid labels = labelsOf(test::ball(3), {9, 9, 9});
  VolumeSurfaceParameters parameters;
  parameters.interpolation.labels = {4, 5};
  try {
    volumeSurface(labels, parameters);
    FAIL();
  } catch (const AbsentLabelError& error) {
    EXPECT_NE(std::string(error.what()).find("labels 4, 5"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("occur are 1."), std::string::npos) << error.what();
  }
}

TEST(VolumeSurface, RefusesParametersOutOfRange) {
  const LabelGrid labels = labelsOf(test::ball(3), {9, 9, 9});
  VolumeSurfaceParameters parameters;
  for (const double bad : {-1.0, 5.1, std::numeric_limits<double>::quiet_NaN()}) {
    parameters.smoothing = bad;
    EXPECT_THROW(volumeSurface(labels, parameters), ParameterError);
  }
  parameters.smoothing = 1;
  for (const double bad :
       {-1.0, 1e-3, 1e-300, 1e3, 1e300, std::numeric_limits<double>::infinity()}) {
    parameters.interpolation.voxelSize = bad;
    EXPECT_THROW(volumeSurface(labels, parameters), ParameterError);
  }
  parameters.interpolation.voxelSize = 0;
  parameters.interpolation.labels = {1, 0};
  EXPECT_THROW(volumeSurface(labels, parameters), ParameterError);
  parameters.interpolation.labels = {1, 2};  // all of a union must be there
  EXPECT_THROW(volumeSurface(labels, parameters), AbsentLabelError);
  parameters.interpolation.labels.clear();
  EXPECT_THROW(volumeSurface(labels, parameters), ParameterError);
  parameters.interpolation = {};
  parameters.interpolation.longestGap = -1;
  EXPECT_THROW(volumeSurface(labels, parameters), ParameterError);
}

}  // namespace
}  // namespace sphere_propagation
