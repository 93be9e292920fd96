// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/digital_topology.h"

#include <gtest/gtest.h>

#include <tuple>

#include "tests/core/label_shapes.h"
#include "tests/core/sizes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/volume/distance_transform.h"
#include "vcg_ext/volume/marching_cubes.h"
#include "vcg_ext/volume/simple_point.h"

namespace sphere_propagation {
namespace {

using test::labelsOf;
using test::maskOf;

/// Components by plain relaxation of labels, connected when the sum of squared steps is at most
/// `reach`.
int countComponents(const Mask& mask, bool inside, int reach) {
  const Eigen::Vector3i n = mask.size;
  std::vector<int> label(mask.values.size(), -1);
  int components = 0;
  for (size_t start = 0; start < label.size(); ++start) {
    if ((mask.values[start] != 0) != inside || label[start] >= 0) continue;
    std::vector<size_t> open{start};
    label[start] = components;
    while (!open.empty()) {
      const auto at = static_cast<int>(open.back());
      open.pop_back();
      const int i = at % n[0], j = at / n[0] % n[1], k = at / n[0] / n[1];
      for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
          for (int x = -1; x <= 1; ++x) {
            if (x * x + y * y + z * z > reach || i + x < 0 || j + y < 0 || k + z < 0 ||
                i + x >= n[0] || j + y >= n[1] || k + z >= n[2])
              continue;
            const size_t next = mask.index(i + x, j + y, k + z);
            if ((mask.values[next] != 0) != inside || label[next] >= 0) continue;
            label[next] = components;
            open.push_back(next);
          }
    }
    ++components;
  }
  return components;
}

long eulerOfMarchingCubes(const Mask& mask) {
  ScalarGrid grid(mask.size, Vector3::Zero(), Vector3::Ones());
  for (size_t i = 0; i < grid.values.size(); ++i) grid.values[i] = mask.values[i];
  const IsoSurface surface = marchingCubes(grid, 0.5, FaceRule::SeparateInside);
  return surface.vertices.rows() - surface.faces.rows() / 2;
}

/// Parts, cavities and handles.
using Betti = std::tuple<int, int, long>;
Betti bettiNumbers(const Mask& mask) {
  const int parts = countComponents(mask, true, 1), cavities = countComponents(mask, false, 2) - 1;
  // Half the surface's characteristic is that of the body: parts - handles + cavities.
  return {parts, cavities, parts + cavities - surfaceEulerCharacteristic(mask) / 2};
}

void expectBalls(const Mask& mask, int parts) { EXPECT_EQ(bettiNumbers(mask), Betti(parts, 0, 0)); }

std::vector<float> depthOf(const Mask& mask) { return signedDistance(mask, Vector3::Ones()); }

TEST(DistanceTransform, IsThatOfBruteForce) {
  test::Random random(3);
  const Vector3 spacing(1.5, 0.7, 2.2);
  for (const int dimensions : {3, 2}) {
    Mask mask({6, 7, 5});
    for (auto& x : mask.values) x = random.uniform() < 0.2;
    mask(1, 1, 2) = mask(2, 3, 1) = mask(0, 0, 0) = mask(5, 5, 3) = mask(4, 1, 4) = 1;
    const std::vector<float> found = signedDistance(mask, spacing, dimensions);
    const double half = 0.35;
    for (int k = 0; k < 5; ++k)
      for (int j = 0; j < 7; ++j)
        for (int i = 0; i < 6; ++i) {
          const bool in = mask(i, j, k) != 0;
          double nearest = 1e300;
          for (int z = 0; z < 5; ++z)
            for (int y = 0; y < 7; ++y)
              for (int x = 0; x < 6; ++x)
                if ((mask(x, y, z) != 0) != in && (dimensions == 3 || z == k))
                  nearest =
                      std::min(nearest, spacing.cwiseProduct(Vector3(x - i, y - j, z - k)).norm());
          EXPECT_NEAR(found[mask.index(i, j, k)], in ? nearest - half : half - nearest, 1e-5);
        }
  }
}

TEST(DistanceTransform, IsInfiniteWhereThereIsNoBorder) {
  Mask mask({3, 3, 2});
  mask(1, 1, 0) = 1;
  const std::vector<float> flat = signedDistance(mask, Vector3::Ones(), 2);
  EXPECT_EQ(flat[mask.index(1, 1, 0)], 0.5F);
  EXPECT_EQ(flat[mask.index(0, 1, 1)], -std::numeric_limits<float>::infinity());
}

TEST(SimplePoint, IsOneThatChangesNoBettiNumber) {
  // A sample of the 2^26 neighbourhoods, of every density. The Betti numbers of the neighbourhood
  // alone tell nearly always; now and then one handle opens while another one closes, which they do
  // not see.
  test::Random random(1);
  const int samples = test::sizeFor(20000, 4000);
  int simple = 0, unseen = 0;
  for (int sample = 0; sample < samples; ++sample) {
    const double share = random.uniform();
    Mask mask({5, 5, 5});
    Neighbourhood bits = 0;
    for (int n = 0; n < 27; ++n) {
      if (n == 13 || random.uniform() >= share) continue;
      bits |= 1U << n;
      mask(n % 3 + 1, n / 3 % 3 + 1, n / 9 + 1) = 1;
    }
    const Betti without = bettiNumbers(mask);
    mask(2, 2, 2) = 1;
    const bool same = without == bettiNumbers(mask);
    ASSERT_TRUE(same || !isSimple(bits)) << "neighbourhood " << bits;
    ASSERT_EQ(isSimple(bits | 1U << 13), isSimple(bits));
    simple += isSimple(bits);
    unseen += same && !isSimple(bits);
  }
  EXPECT_GT(simple, samples / 20);
  EXPECT_LT(unseen, 20);
}

TEST(SimplePoint, OfSmallNeighbourhoods) {
  const auto at = [](int x, int y, int z) { return 1U << (x + 1 + 3 * (y + 1) + 9 * (z + 1)); };
  EXPECT_FALSE(isSimple(0));                           // a part of its own
  EXPECT_FALSE(isSimple((1U << 27) - 1));              // makes or fills a cavity
  EXPECT_TRUE(isSimple(at(1, 0, 0)));                  // the end of a line
  EXPECT_FALSE(isSimple(at(1, 0, 0) | at(-1, 0, 0)));  // joins two
  EXPECT_FALSE(isSimple(at(1, 1, 0)));                 // inside voxels do not touch by edges
  EXPECT_FALSE(isSimple(at(1, 0, 0) | at(0, 1, 0)));   // nor do these two
  EXPECT_TRUE(isSimple(at(1, 0, 0) | at(0, 1, 0) | at(1, 1, 0)));
  EXPECT_TRUE(isSimple(((1U << 27) - 1) & ~at(0, 0, 1)));   // a dent
  EXPECT_TRUE(isSimple(((1U << 27) - 1) & ~at(0, 1, 1)));   // outside voxels touch by edges
  EXPECT_FALSE(isSimple(((1U << 27) - 1) & ~at(1, 1, 1)));  // but not by corners
  EXPECT_FALSE(isSimple(((1U << 27) - 1) & ~at(0, 0, 1) & ~at(0, 0, -1)));  // drills through
}

TEST(SurfaceEulerCharacteristic, IsThatOfMarchingCubes) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Mask mask = maskOf(test::randomBlobs(seed, {12, 13, 14}, seed % 4 * 0.5, seed % 3 * 0.1));
    EXPECT_EQ(surfaceEulerCharacteristic(mask), eulerOfMarchingCubes(mask)) << "seed " << seed;
  }
  EXPECT_EQ(surfaceEulerCharacteristic(maskOf(labelsOf(test::solidTorus(8, 3), {26, 26, 10}))), 0);
  EXPECT_EQ(surfaceEulerCharacteristic(Mask({4, 4, 4})), 0);
}

TEST(MarchingCubes, SeparatesInsideCornersWhateverTheValues) {
  ScalarGrid grid({4, 4, 3}, Vector3::Zero(), Vector3::Ones());
  grid(1, 1, 1) = grid(2, 2, 1) = 1;
  grid(1, 2, 1) = grid(2, 1, 1) = 0.4F;  // the bilinear interpolant joins them
  const IsoSurface joined = marchingCubes(grid, 0.5),
                   apart = marchingCubes(grid, 0.5, FaceRule::SeparateInside);
  EXPECT_EQ(joined.vertices.rows() - joined.faces.rows() / 2, 2);
  EXPECT_EQ(apart.vertices.rows() - apart.faces.rows() / 2, 4);
}

TEST(KeepLargestPart, DropsTheOthersAndSaysHowMuch) {
  Mask mask({12, 5, 5});
  mask(2, 2, 2) = 1;
  mask(5, 2, 2) = mask(6, 2, 2) = mask(7, 2, 2) = 1;
  mask(8, 3, 2) = 1;  // touches by an edge only
  const DroppedParts dropped = keepLargestPart(mask);
  EXPECT_EQ(dropped.parts, 2);
  EXPECT_EQ(dropped.voxels, 2);
  EXPECT_EQ(std::count(mask.values.begin(), mask.values.end(), 1), 3);
  EXPECT_EQ(mask(6, 2, 2), 1);
}

TEST(FillCavities, FillsWhatIsClosedOff) {
  Mask shell =
      maskOf(labelsOf([](const Vector3& x) { return x.norm() < 6 && x.norm() > 3; }, {15, 15, 15}));
  const Mask whole = maskOf(labelsOf(test::ball(6), {15, 15, 15}));
  Mask opened = shell;
  EXPECT_GT(fillCavities(shell), 80);
  EXPECT_EQ(shell.values, whole.values);
  for (int k = 7; k < 15; ++k) opened(7, 7, k) = 0;  // a shaft from outside
  EXPECT_EQ(fillCavities(opened), 0);
}

TEST(RemoveHandles, LeavesABallAlone) {
  Mask mask = maskOf(labelsOf(test::ball(6), {15, 15, 15}));
  const Mask before = mask;
  const RemovedHandles removed = removeHandles(mask, depthOf(mask));
  EXPECT_EQ(removed.by, RemovedHandles::By::Nothing);
  EXPECT_EQ(removed.changedVoxels, 0);
  EXPECT_EQ(mask.values, before.values);
}

TEST(RemoveHandles, CutsAThinRingAndFillsASmallHole) {
  Mask ring = maskOf(labelsOf(test::solidTorus(12, 2), {32, 32, 9}));
  RemovedHandles removed = removeHandles(ring, depthOf(ring));
  EXPECT_EQ(removed.by, RemovedHandles::By::Cutting);
  EXPECT_EQ(removed.handles, 1);
  EXPECT_LT(removed.changedVoxels, 30);  // a cross-section has 13
  EXPECT_GT(removed.changedVoxels, 5);
  expectBalls(ring, 1);

  Mask thick = maskOf(labelsOf(test::solidTorus(8, 6), {33, 33, 17}));
  removed = removeHandles(thick, depthOf(thick));
  EXPECT_EQ(removed.by, RemovedHandles::By::Filling);
  EXPECT_LT(removed.changedVoxels, 30);  // the hole is 4 voxels wide
  expectBalls(thick, 1);
}

TEST(RemoveHandles, CutsAHandleWhereItIsThinnest) {
  // A ball with a bow that is thin on one side.
  const auto shape = [](const Vector3& x) {
    const double angle = std::atan2(x[1], x[0] - 9), tube = 1.8 + 0.8 * std::cos(angle - 1.5);
    return x.norm() < 7 || std::hypot(std::hypot(x[0] - 9, x[1]) - 6, x[2]) < tube;
  };
  Mask mask = maskOf(labelsOf(shape, {42, 24, 19}));
  const Mask before = mask;
  const RemovedHandles removed = removeHandles(mask, depthOf(mask));
  EXPECT_EQ(removed.handles, 1);
  EXPECT_EQ(removed.by, RemovedHandles::By::Cutting);
  EXPECT_LE(removed.changedVoxels, 12);
  for (int k = 0; k < mask.size[2]; ++k)
    for (int j = 0; j < mask.size[1]; ++j)
      for (int i = 0; i < mask.size[0]; ++i)
        if (mask(i, j, k) != before(i, j, k)) {
          EXPECT_LT(j, 11);
        }
  expectBalls(mask, 1);
}

TEST(RemoveHandles, OpensOrFillsACavityThatWasNotFilled) {
  Mask shell =
      maskOf(labelsOf([](const Vector3& x) { return x.norm() < 6 && x.norm() > 3; }, {15, 15, 15}));
  const RemovedHandles removed = removeHandles(shell, depthOf(shell));
  EXPECT_EQ(removed.handles, 0);
  EXPECT_GT(removed.changedVoxels, 0);
  expectBalls(shell, 1);
}

TEST(RemoveHandles, MakesABallOfAnything) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    Mask mask = maskOf(test::randomBlobs(seed, {18, 19, 20}, seed % 4 * 0.7, seed % 5 * 0.05));
    keepLargestPart(mask);
    if (seed % 2 == 0) fillCavities(mask);
    const Mask before = mask;
    const RemovedHandles removed = removeHandles(mask, depthOf(mask));
    ASSERT_NO_FATAL_FAILURE(expectBalls(mask, 1)) << "seed " << seed;
    long changed = 0;
    for (size_t i = 0; i < mask.values.size(); ++i) changed += mask.values[i] != before.values[i];
    EXPECT_EQ(removed.changedVoxels, changed);
  }
}

TEST(RemoveHandles, TreatsEveryPartByItself) {
  const auto torus = test::solidTorus(7, 2);
  Mask mask = maskOf(labelsOf(
      [&](const Vector3& x) { return torus(x - Vector3(0, 0, 5)) || torus(x + Vector3(0, 0, 5)); },
      {24, 24, 22}));
  EXPECT_EQ(bettiNumbers(mask), Betti(2, 0, 2));
  EXPECT_EQ(removeHandles(mask, depthOf(mask)).handles, 2);
  expectBalls(mask, 2);
}

TEST(MoveBySimplePoints, KeepsTheTopologyAndThinSheets) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    Mask mask = maskOf(test::randomBlobs(seed, {16, 17, 18}, 1, 0.02));
    const Betti before = bettiNumbers(mask);
    test::Random random(seed);
    std::vector<float> values;
    for (size_t i = 0; i < mask.values.size(); ++i)
      values.push_back(static_cast<float>(random.normal()));
    moveBySimplePoints(mask, values);
    EXPECT_EQ(bettiNumbers(mask), before);
  }
  // A sheet of one voxel that the values do not want at all: only its rim goes.
  Mask sheet = maskOf(
      labelsOf([](const Vector3& x) { return std::fabs(x[2]) < 0.5 && x.head<2>().norm() < 6; },
               {15, 15, 5}));
  const long before = std::count(sheet.values.begin(), sheet.values.end(), 1);
  moveBySimplePoints(sheet, std::vector<float>(sheet.values.size(), -1));
  EXPECT_GT(std::count(sheet.values.begin(), sheet.values.end(), 1), before / 2);
}

TEST(DigitalTopology, RefusesMasksThatTouchTheBorder) {
  Mask mask({4, 4, 4});
  mask(0, 1, 1) = 1;
  EXPECT_THROW(keepLargestPart(mask), ParameterError);
  EXPECT_THROW(fillCavities(mask), ParameterError);
  EXPECT_THROW(removeHandles(mask, depthOf(mask)), ParameterError);
  EXPECT_THROW(surfaceEulerCharacteristic(Mask()), ParameterError);
  Mask corner({4, 4, 4});  // its first voxel, before which there is nothing to be read
  corner(0, 0, 0) = 1;
  EXPECT_THROW(keepLargestPart(corner), ParameterError);
  EXPECT_THROW(removeHandles(corner, depthOf(corner)), ParameterError);
}

}  // namespace
}  // namespace sphere_propagation
