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

/// Four vertices of a phase, which its own frame moves along; those of another phase lie elsewhere.
Points anchorsOf(const ClosedSurface& surface) {
  Points anchors(4, 3);
  for (int k = 0; k < 4; ++k) anchors.row(k) = surface.vertices().row(100 * k + 7);
  return anchors;
}

TEST(SurfacePoses, AnchorsLayASurfaceWhereShapesSayNothing) {
  // The root itself, turned half round: by its shape it would be found, by anchors it lies where
  // these say, which is exactly the motion.
  const std::vector<ClosedSurface> surfaces{surfaceOf(phaseOf(0)), movedPhase(0),
                                            surfaceOf(phaseOf(0)), surfaceOf(phaseOf(2))};
  std::vector<Points> anchors;
  for (const ClosedSurface& surface : surfaces) anchors.push_back(anchorsOf(surface));
  const Points moved = RigidMotion{turn, shift}.applyTo(anchors[2]);
  anchors[2] = moved;                               // as if it slid: it does not lie there
  anchors[3].topRows(2).setConstant(std::nan(""));  // two are too few
  anchors[1].row(1).setConstant(std::nan(""));      // three are enough
  const std::vector<SurfacePose> poses = posesByAnchors(surfaces, 0, anchors);
  EXPECT_FALSE(poses[0].byAnchors);
  EXPECT_FALSE(poses[3].byAnchors);
  for (const size_t i : {1, 2}) {
    EXPECT_TRUE(poses[i].byAnchors);
    EXPECT_FALSE(poses[i].moved);
    EXPECT_LT((poses[i].toRoot.rotation - turn.transpose()).norm(), 1e-12);
    EXPECT_LT((poses[i].toRoot.translation + turn.transpose() * shift).norm(), 1e-10);
    EXPECT_NEAR(poses[i].angle, 1.1 * 180 / pi, 1e-9);
  }
  // What anchors say stays, and the others are found as always.
  const std::vector<SurfacePose> found = findSurfacePoses(surfaces, star(4, 0), pool, poses);
  EXPECT_EQ(found[2].toRoot.translation, poses[2].toRoot.translation);
  EXPECT_TRUE(found[3].toRoot.isIdentity());
}

TEST(SurfacePoses, AnchorsOnALineLeaveThePoseOpen) {
  const std::vector<ClosedSurface> surfaces{surfaceOf(phaseOf(0)), movedPhase(0)};
  Points line(4, 3);
  for (int k = 0; k < 4; ++k) line.row(k) = Eigen::RowVector3d(k, 2 * k, 5 - k);
  EXPECT_FALSE(posesByAnchors(surfaces, 0, {line, line})[1].byAnchors);
}

}  // namespace
}  // namespace sphere_propagation
