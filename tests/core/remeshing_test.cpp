// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/remeshing/remeshing.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tests/core/test_meshes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/display/colors.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/remeshing/icosphere_remesher.h"
#include "vcg_ext/root_map/root_map.h"
#include "vcg_ext/sphere/sphere_locator.h"

namespace sphere_propagation::test {
namespace {

TEST(Remeshing, AnIcosphereMappedToItselfComesBack) {
  for (const int f : {1, 2, 3, 10}) {
    const Icosphere sphere = icosphere(f);
    const ClosedSurface surface(sphere.vertices, sphere.faces);
    const Remeshed result = remesh(MappedSurface(surface, sphere.vertices), sphere.vertices);
    EXPECT_LT((result.landmarks - sphere.vertices).rowwise().norm().maxCoeff(), 1e-14);
    const SurfaceDistance distance = surfaceDistance(result.landmarks, sphere.faces, surface);
    EXPECT_LT(distance.max, 1e-14);
  }
}

TEST(Remeshing, LandmarksLieOnALidWhereTheirFaceHasACornerOfIt) {
  const Icosphere coarse = icosphere(3), fine = icosphere(12);
  const Remeshed result = remesh(
      MappedSurface(ClosedSurface(coarse.vertices, coarse.faces), coarse.vertices), fine.vertices);
  std::vector<int> lids(92, 0);
  lids[40] = 2;
  const std::vector<int> found = lidsOfLandmarks(result, coarse.faces, lids);
  for (size_t j = 0; j < found.size(); ++j) {
    const bool corner = (coarse.faces.row(result.faces[j]).array() == 40).any();
    EXPECT_EQ(found[j], corner ? 2 : 0);
  }
  EXPECT_GT(std::count(found.begin(), found.end(), 2), 20);
}

TEST(Remeshing, AFinerIcosphereSamplesTheFlatFaces) {
  const Icosphere coarse = icosphere(3), fine = icosphere(12);
  const ClosedSurface surface(coarse.vertices, coarse.faces);
  const Remeshed result = remesh(MappedSurface(surface, coarse.vertices), fine.vertices);
  for (Eigen::Index j = 0; j < fine.vertices.rows();
       ++j)  // along its own direction, below the sphere
    EXPECT_LT((result.landmarks.row(j).normalized() - fine.vertices.row(j)).norm(), 1e-14);
  EXPECT_LT(result.landmarks.rowwise().norm().minCoeff(), 0.98);
  // All samples of the finer mesh that lie on flat faces are on the surface.
  const SurfaceDistance distance = surfaceDistance(result.landmarks, fine.faces, surface);
  EXPECT_LT(distance.max, 1e-14);
}

TEST(Remeshing, ALinearMapOfTheSphereCarriesOver) {
  // The surface is a linear image of its map, so the landmarks are that image of the directions'
  // flat points.
  const Mesh mesh = icosphereMesh(7);
  Eigen::Matrix3d linear;
  linear << 30, 4, -3, 1, 20, 5, 2, -6, 25;
  const Eigen::RowVector3d shift(100, -50, 7);
  const ClosedSurface surface((mesh.vertices * linear.transpose()).rowwise() + shift, mesh.faces);
  const ClosedSurface sphere(mesh.vertices, mesh.faces);
  const Points directions = icosphere(10).vertices;
  const Points flat = remesh(MappedSurface(sphere, mesh.vertices), directions).landmarks;
  const Points landmarks = remesh(MappedSurface(surface, mesh.vertices), directions).landmarks;
  EXPECT_LT(
      (landmarks - ((flat * linear.transpose()).rowwise() + shift)).rowwise().norm().maxCoeff(),
      1e-12);
}

TEST(Remeshing, TurningMapAndDirectionsTogetherChangesNothing) {
  const Mesh mesh = icosphereMesh(6), shape = noisyEllipsoid(2);
  const Mesh map = icosphereMesh(8);
  const ClosedSurface surface(shape.vertices, shape.faces);
  const Points directions = icosphere(9).vertices;
  const Points before = remesh(MappedSurface(surface, map.vertices), directions).landmarks;
  const Eigen::Matrix3d turn = randomRotation(6);
  const Points turnedMap = (map.vertices * turn.transpose()).rowwise().normalized();
  const Points after =
      remesh(MappedSurface(surface, turnedMap), directions * turn.transpose()).landmarks;
  EXPECT_LT((before - after).rowwise().norm().maxCoeff(), 1e-11);
  EXPECT_EQ(before,
            remesh(MappedSurface(surface, map.vertices), directions).landmarks);  // bit for bit
}

TEST(Remeshing, BadDirection) {
  const Mesh mesh = octahedron();
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  EXPECT_THROW(remesh(MappedSurface(surface, mesh.vertices), Points::Zero(1, 3)), ParameterError);
}

TEST(SurfaceDistance, OfConcentricCopies) {
  // A mesh blown up by a factor about its centre: by hand for the octahedron (faces at 1 / sqrt 3
  // of its radius).
  const Mesh inner = octahedron();
  const ClosedSurface surface(inner.vertices, inner.faces);
  const SurfaceDistance distance = surfaceDistance(2 * inner.vertices, inner.faces, surface);
  const double face = 1 / std::sqrt(3.0);
  // Outwards: its corners are 1 away from the inner corners, its centroids `face` from the inner
  // faces. Inwards: the inner corner (1, 0, 0) is (2 - 1) / sqrt 3 from the outer plane x + y + z
  // = 2.
  EXPECT_NEAR(distance.mean, ((0.25 * 1 + 0.75 * face) + face) / 2, 1e-15);
  EXPECT_NEAR(distance.max, 1, 1e-15);
}

TEST(SurfaceDistance, WeighsByArea) {
  // A spike on one side: a vertex of the surface far off, that the other mesh does not have.
  Mesh spiked = icosphereMesh(4);
  spiked.vertices.row(17) *= 3;
  const Mesh plain = icosphereMesh(4);
  const ClosedSurface surface(spiked.vertices, spiked.faces);
  const SurfaceDistance distance = surfaceDistance(plain.vertices, plain.faces, surface);
  EXPECT_NEAR(distance.max, 2, 1e-14);  // only the way back sees it
  EXPECT_GT(distance.mean, 0.01);
  EXPECT_LT(distance.mean, 0.2);
}

TEST(SurfaceDistance, FallsWithTheSquareOfTheSpacing) {
  const Mesh mesh = ellipsoid(3, 2, 1, 40), map = icosphereMesh(40);
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  const MappedSurface sphere(surface, map.vertices);
  const auto distance = [&](int f) {
    const Icosphere ico = icosphere(f);
    return surfaceDistance(remesh(sphere, ico.vertices).landmarks, ico.faces, surface).mean;
  };
  const double ratio = distance(5) / distance(10);
  EXPECT_GT(ratio, 3.4);
  EXPECT_LT(ratio, 4.6);
}

TEST(SurfaceDistance, LandmarksWithoutArea) {
  const Mesh mesh = octahedron();
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  const SurfaceDistance distance =
      surfaceDistance(Points::Zero(3, 3), Triangles{{0, 1, 2}}, surface);
  EXPECT_NEAR(distance.max, 1, 1e-15);
  EXPECT_NEAR(distance.mean, (1 / std::sqrt(3.0) + 1) / 2, 1e-15);
}

TEST(IcosphereRemesher, SamplesAndMeasuresAsWithoutHints) {
  const Mesh map = icosphereMesh(16);
  const Points turned = map.vertices * randomRotation(2).transpose();
  for (const Mesh& shape : {ellipsoid(3, 2, 1, 16), cup(0.2, 40, 40), ellipsoid(1, 1, 30, 16)}) {
    const bool own = shape.vertices.rows() != turned.rows();
    const ClosedSurface surface(shape.vertices, shape.faces);
    const MappedSurface sphere =
        own ? makeRootMap(surface).map : MappedSurface(surface, turned.rowwise().normalized());
    for (const int frequency : {1, 4, 10, 30}) {
      const IcosphereRemesher remesher(frequency);
      const Points& directions = remesher.sphere().vertices;
      const Remeshed remeshed = remesher.remesh(sphere);
      EXPECT_EQ(remeshed.landmarks, remesh(sphere, directions).landmarks);
      const SphereLocator locator(sphere);
      for (Eigen::Index j = 0; j < directions.rows(); ++j)
        EXPECT_EQ(remeshed.faces[static_cast<size_t>(j)],
                  locator.locate(directions.row(j).transpose()).face);
      const SurfaceDistance found = remesher.distance(remeshed, sphere);
      const SurfaceDistance expected =
          surfaceDistance(remeshed.landmarks, remesher.sphere().faces, surface);
      EXPECT_NEAR(found.mean, expected.mean, 1e-14);
      EXPECT_NEAR(found.max, expected.max, 1e-14);
    }
  }
}

TEST(IcosphereRemesher, BadFrequency) { EXPECT_THROW(IcosphereRemesher(0), ParameterError); }

TEST(LandmarkColors, HuesOfAWholeTurn) {
  const Colors colors = landmarkColors(12);
  Colors expected(12, 3);
  expected << 255, 0, 0, 255, 128, 0, 255, 255, 0, 128, 255, 0, 0, 255, 0, 0, 255, 128, 0, 255, 255,
      0, 128, 255, 0, 0, 255, 128, 0, 255, 255, 0, 255, 255, 0, 128;
  EXPECT_EQ(colors, expected);
  EXPECT_EQ(landmarkColors(0).rows(), 0);
  EXPECT_EQ(landmarkColors(1), (Colors(1, 3) << 255, 0, 0).finished());
}

TEST(LandmarkColors, FullSaturationAndValueAndSmooth) {
  const Colors colors = landmarkColors(1002);
  for (Eigen::Index j = 0; j < 1002; ++j) {
    EXPECT_EQ(colors.row(j).maxCoeff(), 255);
    EXPECT_EQ(colors.row(j).minCoeff(), 0);
    const Eigen::RowVector3i step =
        colors.row(j).cast<int>() - colors.row((j + 1) % 1002).cast<int>();
    EXPECT_LE(step.cwiseAbs().sum(), 3);
  }
  // On the icosphere neighbours never lie more than two rows apart: 36 degrees of hue.
  const Icosphere sphere = icosphere(10);
  for (Eigen::Index f = 0; f < sphere.faces.rows(); ++f)
    EXPECT_LE(sphere.faces.row(f).maxCoeff() - sphere.faces.row(f).minCoeff(), 100);
}

}  // namespace
}  // namespace sphere_propagation::test
