// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/repair/float_copy.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/core/test_meshes.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation::test {
namespace {

struct ReadBack {
  TextureCopy copy;
  Points positions;  ///< read back
  double farthest;   ///< from the original
  bool certified;
};

/// A mesh on the sphere as its own map, written and read back.
ReadBack throughTexture(const Mesh& mesh) {
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  ReadBack result;
  result.copy = copyToTexture(MappedSurface(surface, mesh.vertices));
  result.positions = positionsFromTexture(result.copy.numbers);
  result.farthest = (result.positions - mesh.vertices).rowwise().norm().maxCoeff();
  result.certified = certify(mesh.faces, result.positions).valid();
  EXPECT_EQ(result.copy.valid, result.certified);
  EXPECT_GE(result.copy.numbers.minCoeff(), 0);
  EXPECT_LE(result.copy.numbers.maxCoeff(), 1);
  return result;
}

TEST(TextureCopy, OrdinaryMapsNeedNoMending) {
  // The octahedron has vertices at both poles and on longitude 0; the turned spheres have edges
  // across it.
  for (const Mesh& mesh : {octahedron(), icosahedron(), icosphereMesh(10), bipyramid(7)})
    for (unsigned seed = 0; seed < 4; ++seed) {
      const ReadBack copied = throughTexture(
          seed == 0 ? mesh : transformed(mesh, randomRotation(seed), 1, Vector3::Zero()));
      EXPECT_TRUE(copied.copy.valid);
      EXPECT_EQ(copied.copy.mendedVertices, 0);
      EXPECT_LT(copied.farthest, 4e-7);
    }
}

TEST(TextureCopy, VerticesBesideTheDateLineAndThePoles) {
  // Longitudes so little below the full turn that they round to it.
  Mesh mesh = octahedron();
  for (const double off : {1e-5, 1e-8, 1e-12, 1e-17}) {
    mesh.vertices.row(0) = Eigen::RowVector3d(1, -off, 0).normalized();
    mesh.vertices.row(4) = Eigen::RowVector3d(-off, off, 1).normalized();
    mesh.vertices.row(5) = Eigen::RowVector3d(off, -off, -1).normalized();
    const ReadBack copied = throughTexture(mesh);
    EXPECT_TRUE(copied.copy.valid);
    EXPECT_LT(copied.farthest, 4e-7);
  }
}

TEST(TextureCopy, TinyFacesAtThePoleKeepTheirDigits) {
  const ReadBack copied = throughTexture(rings(1e-6));
  EXPECT_TRUE(copied.copy.valid);
  EXPECT_EQ(copied.copy.mendedVertices, 0);
}

TEST(TextureCopy, MendsWhatRoundingFlips) {
  // Elsewhere floats are up to 4e-7 apart: rounding flips faces no larger than that, and moving
  // vertices mends most.
  int mended = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Mesh mesh = transformed(rings(2.5e-7), randomRotation(seed), 1, Vector3::Zero());
    const ReadBack copied = throughTexture(mesh);
    if (copied.copy.mendedVertices == 0) continue;
    mended += copied.copy.valid;
    EXPECT_LT(copied.farthest, 1e-5);
  }
  EXPECT_GT(mended, 5);
}

TEST(TextureCopy, SaysWhenFloatsCannotHoldTheMap) {
  int invalid = 0;  // throughTexture compares the answer with the certificate of what is read back
  for (unsigned seed = 0; seed < 20; ++seed)
    invalid += !throughTexture(transformed(rings(1.7e-7), randomRotation(seed), 1, Vector3::Zero()))
                    .copy.valid;
  EXPECT_GT(invalid, 0);
}

TEST(TextureCopy, OrdinaryTextureIsNoMap) {
  // A planar texture of a mesh does not certify.
  const Mesh mesh = icosphereMesh(4);
  TextureCopy::Numbers planar =
      (0.5 * mesh.vertices.leftCols(2).array() + 0.5).cast<float>().matrix();
  EXPECT_FALSE(certify(mesh.faces, positionsFromTexture(planar)).valid());
}

}  // namespace
}  // namespace sphere_propagation::test
