// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/surface_poses.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>

#include "tests/core/test_meshes.h"
#include "tests/core/test_pool.h"

namespace sphere_propagation {
namespace {

using test::pool;

using test::Mesh;

/// A lopsided shape that shrinks a little from phase to phase.
Mesh phaseOf(int phase) {
  Mesh mesh = test::transformed(test::icosphereMesh(9 + phase % 2),
                                test::randomRotation(20 + phase), 1, Vector3::Zero());
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    const Vector3 d = mesh.vertices.row(v).transpose();
    mesh.vertices.row(v) *= 1 + 0.5 * std::exp(-4 * (d - Vector3(0.6, 0.64, 0.48)).squaredNorm()) +
                            0.4 * std::exp(-6 * (d - Vector3(-0.48, 0.6, 0.64)).squaredNorm());
  }
  mesh.vertices *= (1 - 0.02 * phase) * Vector3(40, 30, 22).asDiagonal();
  return mesh;
}

std::vector<ClosedSurface> sequence(int phases) {
  std::vector<ClosedSurface> surfaces;
  for (int i = 0; i < phases; ++i) surfaces.push_back(surfaceOf(phaseOf(i)));
  return surfaces;
}

const Eigen::Matrix3d turn =
    Eigen::AngleAxisd(1.1, Vector3(1, 2, -1).normalized()).toRotationMatrix();
const Vector3 shift(60, -10, 5);

ClosedSurface movedPhase(int phase) {
  return surfaceOf(test::transformed(phaseOf(phase), turn, 1, shift));
}

TEST(SurfacePoses, ASequenceInOneFrameStaysAsItLies) {
  for (const PropagationTree& tree : {timeOrder(6, 2), star(6, 0)})
    for (const SurfacePose& pose : findSurfacePoses(sequence(6), tree, pool)) {
      EXPECT_FALSE(pose.moved);
      EXPECT_EQ(pose.toRoot.rotation, Eigen::Matrix3d::Identity());
      EXPECT_EQ(pose.toRoot.translation, Vector3::Zero());
    }
}

TEST(SurfacePoses, OneLayerElsewhereIsBroughtBackAlone) {
  std::vector<ClosedSurface> surfaces = sequence(5);
  surfaces[2] = movedPhase(2);
  const std::vector<SurfacePose> poses = findSurfacePoses(surfaces, timeOrder(5, 0), pool);
  for (size_t i : {0, 1, 3, 4}) EXPECT_FALSE(poses[i].moved) << i;
  EXPECT_EQ(poses[3].toRoot.rotation, Eigen::Matrix3d::Identity());
  EXPECT_TRUE(poses[2].moved);
  EXPECT_NEAR(poses[2].angle, 1.1 * 180 / pi, 2);
  EXPECT_LT((poses[2].toRoot.rotation * turn - Eigen::Matrix3d::Identity()).norm(), 0.04);
  EXPECT_LT((laidInRootsFrame(surfaces, poses).surface(2).vertices() - phaseOf(2).vertices)
                .rowwise()
                .norm()
                .maxCoeff(),
            2);
}

TEST(SurfacePoses, LayersBehindOneThatMovedShareItsPose) {
  std::vector<ClosedSurface> surfaces = sequence(5);
  for (int i = 2; i < 5; ++i) surfaces[static_cast<size_t>(i)] = movedPhase(i);
  const std::vector<SurfacePose> poses = findSurfacePoses(surfaces, timeOrder(5, 0), pool);
  EXPECT_TRUE(poses[2].moved);
  for (size_t i : {3, 4}) {
    EXPECT_FALSE(poses[i].moved) << i;  // relative to its parent it lies as it should
    EXPECT_EQ(poses[i].toRoot.rotation, poses[2].toRoot.rotation);
  }
}

TEST(SurfacePoses, BehindALayerOfAnotherKindTheDistanceIsComparedWithTheShapeThatGaveThePose) {
  // The last layer lies as it should in the root, which is larger; the layer between them is its
  // mirror image, turned, and so fits it far better than the root does.
  const Mesh small =
      test::transformed(phaseOf(0), Eigen::Matrix3d::Identity(), 0.8, Vector3::Zero());
  const Eigen::Matrix3d aside = Eigen::AngleAxisd(0.5, Vector3::UnitZ()).toRotationMatrix();
  const std::vector<ClosedSurface> surfaces{
      surfaceOf(phaseOf(0)),
      surfaceOf(test::transformed(test::mirrored(small), aside, 1, Vector3::Zero())),
      surfaceOf(small)};
  const std::vector<SurfacePose> poses = findSurfacePoses(surfaces, timeOrder(3, 0), pool);
  for (size_t i : {1, 2}) EXPECT_FALSE(poses[i].moved) << i;
}

}  // namespace
}  // namespace sphere_propagation
