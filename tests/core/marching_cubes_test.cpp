// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/marching_cubes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "tests/core/test_meshes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/volume/gaussian_smoothing.h"

namespace sphere_propagation {
namespace {

using test::pi;

/// radius - |x - centre|, on a grid that holds the sphere with room to spare.
ScalarGrid sphereGrid(double radius, double h, const Vector3& centre) {
  const int n = static_cast<int>(2 * radius / h) + 6;
  ScalarGrid grid({n, n + 1, n + 2}, centre - Vector3::Constant(std::floor(n / 2.0) * h),
                  {h, h, h});
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vector3 x = grid.origin + grid.spacing.cwiseProduct(Vector3(i, j, k));
        grid(i, j, k) = static_cast<float>(radius - (x - centre).norm());
      }
  return grid;
}

/// Every edge with two faces that run along it in opposite directions, every vertex with one fan,
/// none unused or twice.
::testing::AssertionResult closedManifold(const IsoSurface& surface) {
  std::map<std::pair<int, int>, int> halfEdges;
  std::map<int, std::map<int, int>> fans;  // per vertex: from each neighbour to the next
  for (Eigen::Index f = 0; f < surface.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = surface.faces(f, k), b = surface.faces(f, (k + 1) % 3),
                c = surface.faces(f, (k + 2) % 3);
      if (++halfEdges[{a, b}] > 1)
        return ::testing::AssertionFailure() << "edge " << a << " " << b << " comes twice";
      fans[a][b] = c;
    }
  for (const auto& [edge, count] : halfEdges)
    if (halfEdges.count({edge.second, edge.first}) != 1)
      return ::testing::AssertionFailure()
             << "edge " << edge.first << " " << edge.second << " is open";
  if (static_cast<Eigen::Index>(fans.size()) != surface.vertices.rows())
    return ::testing::AssertionFailure() << "there are unused vertices";
  for (const auto& [vertex, next] : fans) {
    size_t steps = 0;
    int w = next.begin()->first;
    do {
      w = next.at(w);
      ++steps;
    } while (w != next.begin()->first);
    if (steps != next.size())
      return ::testing::AssertionFailure() << "vertex " << vertex << " has several fans";
  }
  std::set<std::tuple<double, double, double>> places;
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
    if (!places.insert({surface.vertices(v, 0), surface.vertices(v, 1), surface.vertices(v, 2)})
             .second)
      return ::testing::AssertionFailure() << "vertex " << v << " lies where another one does";
  return ::testing::AssertionSuccess();
}

long eulerCharacteristic(const IsoSurface& surface) {
  return surface.vertices.rows() - surface.faces.rows() / 2;
}

TEST(MarchingCubes, OfOneVoxelIsAnOctahedron) {
  ScalarGrid grid({3, 3, 3}, {10, 20, 30}, {1, 2, 4});
  grid(1, 1, 1) = 1;
  const IsoSurface surface = marchingCubes(grid, 0.5);
  EXPECT_EQ(surface.vertices.rows(), 6);
  EXPECT_EQ(surface.faces.rows(), 8);
  EXPECT_TRUE(closedManifold(surface));
  EXPECT_NEAR(enclosedVolume(surface.vertices, surface.faces), 4.0 / 3 * 0.5 * 1 * 2,
              1e-12);  // half axes 0.5, 1, 2
  EXPECT_NEAR((surface.vertices.colwise().mean() - Eigen::RowVector3d(11, 22, 34)).norm(), 0,
              1e-12);
}

TEST(MarchingCubes, OfASphereConvergesInVolumeAndArea) {
  const double radius = 10;
  const Vector3 centre(3.1, -2.2, 0.7);
  double before = 0;
  for (const double h : {2.0, 1.0, 0.5}) {
    const IsoSurface surface = marchingCubes(sphereGrid(radius, h, centre), 0);
    const ClosedSurface closed(surface.vertices, surface.faces);
    const double volume =
        enclosedVolume(surface.vertices, surface.faces) / (4 * pi / 3 * std::pow(radius, 3));
    const double area =
        faceAreas(surface.vertices, surface.faces).sum() / (4 * pi * radius * radius);
    EXPECT_LT(volume, 1);
    EXPECT_NEAR(volume, 1, 0.01 * h * h);
    EXPECT_NEAR(area, 1, 0.01 * h * h);
    if (before > 0) {
      EXPECT_LT(1 - volume, 0.35 * before);  // second order: a quarter
    }
    before = 1 - volume;
    EXPECT_LT(((surface.vertices.rowwise() - centre.transpose()).rowwise().norm().array() - radius)
                  .abs()
                  .maxCoeff(),
              0.02 * h * h);
  }
}

TEST(MarchingCubes, HasOneVertexPerCutGridEdge) {
  const ScalarGrid grid = sphereGrid(8, 1, Vector3::Zero());
  long cut = 0;
  const Eigen::Vector3i n = grid.size;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        const bool in = grid(i, j, k) > 0;
        cut += i + 1 < n[0] && in != (grid(i + 1, j, k) > 0);
        cut += j + 1 < n[1] && in != (grid(i, j + 1, k) > 0);
        cut += k + 1 < n[2] && in != (grid(i, j, k + 1) > 0);
      }
  const IsoSurface surface = marchingCubes(grid, 0);
  EXPECT_EQ(surface.vertices.rows(), cut);
  EXPECT_EQ(eulerCharacteristic(surface), 2);
}

TEST(MarchingCubes, OfEveryCellIsClosed) {
  // All 256 patterns of one cell, with values that are ties at every ambiguous face and with values
  // that are not.
  test::Random random(1);
  for (int pattern = 0; pattern < 256; ++pattern)
    for (int repeat = 0; repeat < 20; ++repeat) {
      ScalarGrid grid({2, 2, 2}, Vector3::Zero(), Vector3::Ones());
      for (int c = 0; c < 8; ++c) {
        const double size = repeat == 0 ? 1 : random.uniform(0.1, 1);
        grid.values[static_cast<size_t>(c)] =
            static_cast<float>((pattern >> c & 1) != 0 ? size : -size);
      }
      ASSERT_TRUE(closedManifold(marchingCubes(grid, 0))) << "pattern " << pattern;
    }
}

TEST(MarchingCubes, StaysClosedWithNoiseTiesAndExactHits) {
  // Coin tosses are ambiguous nearly everywhere; few levels make ties and values that equal the iso
  // value.
  for (unsigned seed = 0; seed < 30; ++seed) {
    test::Random random(seed);
    ScalarGrid grid({9, 10, 11}, Vector3::Zero(), Vector3::Ones());
    for (float& x : grid.values) {
      const int kind = static_cast<int>(seed % 3);
      x = kind == 0   ? static_cast<float>(random.index(2))
          : kind == 1 ? static_cast<float>(random.index(5)) / 4
                      : static_cast<float>(random.uniform());
    }
    const IsoSurface surface = marchingCubes(grid, 0.5);
    ASSERT_GT(surface.faces.rows(), 100);
    ASSERT_TRUE(closedManifold(surface)) << "seed " << seed;
    EXPECT_GT(enclosedVolume(surface.vertices, surface.faces), 0);
    EXPECT_GT(faceAreas(surface.vertices, surface.faces).minCoeff(), 0);
  }
}

TEST(MarchingCubes, KeepsDiagonalVoxelsApartAndDecidesByTheInterpolant) {
  ScalarGrid grid({4, 4, 3}, Vector3::Zero(), Vector3::Ones());
  grid(1, 1, 1) = grid(2, 2, 1) = 1;
  EXPECT_EQ(eulerCharacteristic(marchingCubes(grid, 0.5)),
            4);                          // two spheres: at the tie they do not touch
  grid(1, 2, 1) = grid(2, 1, 1) = 0.4F;  // the saddle is now above 0.5
  EXPECT_EQ(eulerCharacteristic(marchingCubes(grid, 0.5)), 2);  // one
}

TEST(MarchingCubes, ClosesWhatTouchesTheBorder) {
  ScalarGrid full({3, 4, 5}, {1, 1, 1}, {2, 1, 1});
  std::fill(full.values.begin(), full.values.end(), 7.0F);
  const IsoSurface box = marchingCubes(full, 0.5);
  EXPECT_TRUE(closedManifold(box));
  EXPECT_EQ(box.vertices.col(0).minCoeff(), 0);
  EXPECT_EQ(box.vertices.col(0).maxCoeff(), 6);
  EXPECT_EQ(box.vertices.col(2).maxCoeff(), 5.5);
  const ScalarGrid one({1, 1, 1}, Vector3::Zero(), Vector3::Ones());
  EXPECT_EQ(marchingCubes(one, 0.5).faces.rows(), 0);
}

TEST(MarchingCubes, BearsNumbersThatAreNone) {
  ScalarGrid grid = sphereGrid(4, 1, Vector3::Zero());
  grid(3, 4, 5) = std::numeric_limits<float>::quiet_NaN();
  grid(4, 4, 4) = std::numeric_limits<float>::infinity();
  const IsoSurface surface = marchingCubes(grid, 0);
  EXPECT_TRUE(closedManifold(surface));
  EXPECT_TRUE(surface.vertices.allFinite());
}

TEST(MarchingCubes, RefusesGridsThatAreNone) {
  const ScalarGrid good = sphereGrid(2, 1, Vector3::Zero());
  ScalarGrid bad = good;
  bad.values.pop_back();
  EXPECT_THROW(marchingCubes(bad, 0), ParameterError);
  bad = good;
  bad.spacing[1] = 0;
  EXPECT_THROW(marchingCubes(bad, 0), ParameterError);
  EXPECT_THROW(marchingCubes(ScalarGrid(), 0), ParameterError);
  EXPECT_THROW(marchingCubes(good, std::numeric_limits<double>::quiet_NaN()), ParameterError);
}

TEST(LargestPart, IsTheOneWithTheMostVertices) {
  ScalarGrid grid({12, 5, 5}, Vector3::Zero(), Vector3::Ones());
  grid(2, 2, 2) = 1;
  grid(6, 2, 2) = grid(7, 2, 2) = grid(8, 2, 2) = 1;
  grid(10, 2, 2) = 1;
  const IsoSurface all = marchingCubes(grid, 0.5), largest = largestPart(all);
  EXPECT_EQ(all.vertices.rows(), 6 + 14 + 6);
  EXPECT_EQ(largest.vertices.rows(), 14);
  EXPECT_TRUE(closedManifold(largest));
  EXPECT_EQ(largest.vertices.col(0).minCoeff(), 5.5);
  EXPECT_EQ(largest.vertices.col(0).maxCoeff(), 8.5);
  EXPECT_EQ(largestPart(IsoSurface()).faces.rows(), 0);
}

TEST(GaussianSmoothing, IsScipys) {
  // import numpy, scipy.ndimage
  // a = (numpy.arange(60) ** 2 % 17).reshape(5, 4, 3).astype(float)  # z, y, x
  // b = scipy.ndimage.gaussian_filter(a, 0.7); print(b[0, 0, 0], b[2, 1, 1], b[4, 3, 2], b[3, 0,
  // 2]) b = scipy.ndimage.gaussian_filter(a, 2.0); print(b[0, 0, 0], b[2, 1, 1])  # the kernel is
  // wider than the grid
  ScalarGrid grid({3, 4, 5}, Vector3::Zero(), Vector3::Ones());
  for (size_t i = 0; i < 60; ++i) grid.values[i] = static_cast<float>(i * i % 17);
  ScalarGrid narrow = grid, wide = grid;
  smoothGaussian(narrow, 0.7);
  smoothGaussian(wide, 2.0);
  EXPECT_NEAR(narrow(0, 0, 0), 3.8545772457, 2e-6);
  EXPECT_NEAR(narrow(1, 1, 2), 7.5168906828, 2e-6);
  EXPECT_NEAR(narrow(2, 3, 4), 12.7273685932, 2e-6);
  EXPECT_NEAR(narrow(2, 0, 3), 10.8439480048, 2e-6);
  EXPECT_NEAR(wide(0, 0, 0), 7.6502868794, 2e-6);
  EXPECT_NEAR(wide(1, 1, 2), 7.9255379024, 2e-6);
}

TEST(GaussianSmoothing, KeepsConstantsAndSumsAndDoesNothingAtZero) {
  ScalarGrid grid({6, 7, 8}, Vector3::Zero(), Vector3::Ones());
  test::Random random(2);
  double sum = 0, smoothed = 0;
  for (float& x : grid.values)
    x = static_cast<float>(random.uniform()), sum += static_cast<double>(x);
  ScalarGrid same = grid;
  smoothGaussian(same, 0);
  EXPECT_EQ(same.values, grid.values);
  smoothGaussian(grid, 1.3);
  for (float x : grid.values) smoothed += static_cast<double>(x);
  EXPECT_NEAR(smoothed, sum, 1e-3);
  std::fill(grid.values.begin(), grid.values.end(), 3.0F);
  smoothGaussian(grid, 1.3);
  for (float x : grid.values) EXPECT_NEAR(x, 3, 1e-6);
  EXPECT_THROW(smoothGaussian(grid, -1), ParameterError);
  EXPECT_THROW(smoothGaussian(grid, 1, 0), ParameterError);
  EXPECT_THROW(smoothGaussian(grid, 1e300), ParameterError);
  EXPECT_THROW(smoothGaussian(grid, std::numeric_limits<double>::quiet_NaN()), ParameterError);
}

}  // namespace
}  // namespace sphere_propagation
