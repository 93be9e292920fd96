// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sphere/repair/float_copy.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/core/sizes.h"
#include "tests/core/test_meshes.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation::test {
namespace {

struct Copied {
  PositionCopy copy;
  double farthest;  ///< from the original
};

/// A mesh on the sphere as its own map. What the copy says of itself must be what the certificate
/// says of the floats.
Copied asFloat(const Mesh& mesh) {
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  Copied result{copyToFloat(MappedSurface(surface, mesh.vertices)), 0};
  const Points positions = result.copy.numbers.cast<double>();
  result.farthest = (positions - mesh.vertices).rowwise().norm().maxCoeff();
  EXPECT_EQ(result.copy.valid, certify(mesh.faces, positions).valid());
  return result;
}

TEST(FloatCopy, OrdinaryMapsAreRoundedAndNoMore) {
  for (const Mesh& mesh : {octahedron(), icosahedron(), icosphereMesh(10), bipyramid(7)})
    for (unsigned seed = 0; seed < 4; ++seed) {
      const Mesh turned =
          seed == 0 ? mesh : transformed(mesh, randomRotation(seed), 1, Vector3::Zero());
      const Copied copied = asFloat(turned);
      EXPECT_TRUE(copied.copy.valid);
      EXPECT_EQ(copied.copy.mendedVertices, 0);
      EXPECT_EQ(copied.copy.numbers, turned.vertices.cast<float>());
      EXPECT_LT(copied.farthest, 1e-7);
    }
}

TEST(FloatCopy, MendsWhatRoundingFlips) {
  // Floats are up to 6e-8 apart: rounding flips faces not much larger than that, and moving
  // vertices mends many.
  int mended = 0;
  for (const double least : {1.7e-7, 2e-7})
    for (unsigned seed = 0; seed < 100; ++seed) {
      const Copied copied =
          asFloat(transformed(rings(least), randomRotation(seed), 1, Vector3::Zero()));
      if (copied.copy.mendedVertices == 0) continue;
      mended += copied.copy.valid;
      EXPECT_LT(copied.farthest, 2e-6);
    }
  EXPECT_GT(mended, 5);
}

TEST(FloatCopy, SaysWhenFloatsCannotHoldTheMap) {
  // Needles from both poles to an equator on which 100 vertices lie 1e-10 apart, where floats are
  // 6e-8 apart.
  const int close = sizeFor(100, 40), sides = close + 3;
  Mesh mesh = bipyramid(sides);
  for (int i = 0; i < sides; ++i) {
    const double longitude = i < close ? 1e-10 * i : (i - close + 1) * pi / 2;
    mesh.vertices.row(2 + i) << std::cos(longitude), std::sin(longitude), 0;
  }
  int invalid = 0;  // asFloat compares the answer with the certificate of the floats
  for (unsigned seed = 0; seed < 5; ++seed)
    invalid += !asFloat(transformed(mesh, randomRotation(seed), 1, Vector3::Zero())).copy.valid;
  EXPECT_GT(invalid, 0);
}

}  // namespace
}  // namespace sphere_propagation::test
