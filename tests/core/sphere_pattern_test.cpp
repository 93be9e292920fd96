// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/display/sphere_pattern.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/test_meshes.h"
#include "vcg_ext/base/error.h"

namespace sphere_propagation::test {
namespace {

Vector3 at(double longitude, double colatitude) {
  return {std::sin(colatitude) * std::cos(longitude), std::sin(colatitude) * std::sin(longitude),
          std::cos(colatitude)};
}

Eigen::RowVector3i colorAt(const Vector3& position, double spacing,
                           const SpherePatternParameters& parameters) {
  Points points(1, 3);
  points.row(0) = position.transpose();
  return sphereColors(points, Eigen::VectorXd::Constant(1, spacing), parameters).row(0).cast<int>();
}

/// How dark a field of the checkerboard is against the colour that it has without fields: 1 light,
/// 0.5 dark.
double shade(const Vector3& position, double spacing, int cells) {
  const Eigen::RowVector3i patterned =
      colorAt(position, spacing, {SpherePattern::Checkerboard, cells});
  const Eigen::RowVector3i mean =
      colorAt(position, 1e3, {SpherePattern::Checkerboard, cells});  // 0.75
  return 0.75 * patterned.sum() / mean.sum();
}

TEST(SpherePattern, TheCheckerboardHasItsFields) {
  for (const int cells : {2, 4, 5, 8, 13}) {
    const SpherePatternParameters parameters{SpherePattern::Checkerboard, cells};
    EXPECT_EQ(parameters.around() % 2, 0);
    EXPECT_NEAR(parameters.around(), 1.5 * cells, 1);
    for (int i = 0; i < parameters.around(); ++i)
      for (int j = 0; j < cells; ++j)
        for (const double inside : {0.03, 0.5, 0.97}) {
          const Vector3 p =
              at(2 * pi * (i + inside) / parameters.around(), pi * (j + inside) / cells);
          EXPECT_NEAR(shade(p, 0, cells), (i + j) % 2 == 0 ? 1 : 0.5, 0.02)
              << cells << ": " << i << ", " << j;
        }
  }
}

TEST(SpherePattern, EdgesAreHalfWayBetweenTheirFields) {
  for (const double spacing : {0.01, 0.05, 0.1})
    for (int i = 0; i < 12; ++i) {
      EXPECT_NEAR(shade(at(2 * pi * i / 12, pi * 3.5 / 8), spacing, 8), 0.75, 0.02);
      EXPECT_NEAR(shade(at(2 * pi * (i + 0.5) / 12, pi * 3 / 8), spacing, 8), 0.75, 0.02);
    }
}

TEST(SpherePattern, InterpolatedColorsChangeWhereTheEdgeIs) {
  // Two neighbours on the equator with the edge somewhere between them: where their interpolated
  // shade is 0.75 is off by less than an eighth of their distance. Without blending it would be off
  // by up to a half.
  const double spacing = 0.06, edge = 2 * pi / 12;
  for (double offset = 0.02; offset < 1; offset += 0.04) {
    const double before = shade(at(edge - offset * spacing, pi * 4.5 / 8), spacing, 8);
    const double behind = shade(at(edge + (1 - offset) * spacing, pi * 4.5 / 8), spacing, 8);
    ASSERT_LT((before - 0.75) * (behind - 0.75), 0);
    EXPECT_NEAR((before - 0.75) / (before - behind), offset, 0.14);
  }
}

TEST(SpherePattern, WhatIsTooFineForAMeshBecomesItsMean) {
  // Fields of 1.8 degrees at vertices 10 degrees apart.
  Random random(5);
  for (int i = 0; i < 50; ++i)
    EXPECT_NEAR(shade(random.direction(), 10 * pi / 180, 100), 0.75, 0.05);
}

TEST(SpherePattern, AllMeridiansMeetInTheColorOfThePole) {
  for (const SpherePattern pattern :
       {SpherePattern::Checkerboard, SpherePattern::Graticule, SpherePattern::Direction})
    for (const double colatitude : {0.0, pi}) {
      const Eigen::RowVector3i pole = colorAt(at(0, colatitude), 0.05, {pattern, 8});
      for (int i = 0; i < 24; ++i) {
        const Eigen::RowVector3i near =
            colorAt(at(2 * pi * i / 24, std::fabs(colatitude - 1e-6)), 0.05, {pattern, 8});
        EXPECT_LE((near - pole).cwiseAbs().maxCoeff(), 1)
            << static_cast<int>(pattern) << ", meridian " << i;
      }
    }
  const SpherePatternParameters direction{SpherePattern::Direction, 8};
  EXPECT_GT(colorAt(at(0, 0), 0, direction).sum(), 2 * colorAt(at(0, pi), 0, direction).sum());
}

TEST(SpherePattern, DirectionsDifferAndHaveNoEdges) {
  const SpherePatternParameters direction{SpherePattern::Direction, 8};
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    const Vector3 p = random.direction(), q = (p + 0.01 * random.direction()).normalized();
    EXPECT_LE((colorAt(p, 0, direction) - colorAt(q, 0, direction)).cwiseAbs().maxCoeff(), 12);
  }
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < i; ++j)
      EXPECT_GT(
          (colorAt(at(i * pi / 6, 1.4), 0, direction) - colorAt(at(j * pi / 6, 1.4), 0, direction))
              .norm(),
          30);
}

TEST(SpherePattern, TheGraticuleHasBlackZeroLinesAndWhiteFields) {
  const SpherePatternParameters graticule{SpherePattern::Graticule, 8};
  for (const double spacing : {0.0, 0.04}) {
    EXPECT_LT(colorAt(at(0, 1.0), spacing, graticule).maxCoeff(), 10);
    EXPECT_LT(colorAt(at(1.1, pi / 2), spacing, graticule).maxCoeff(), 10);
    int lines = 0, steps = 4800;
    bool onLine = true;  // begins on the 0 meridian
    for (int i = 0; i < steps; ++i) {
      const auto color = colorAt(at(2 * pi * i / steps, pi * 3.5 / 8), spacing, graticule);
      const bool now = color.minCoeff() < 200;
      if (now && !onLine) ++lines;
      onLine = now;
    }
    EXPECT_EQ(lines, graticule.around());
    for (int i = 0; i < graticule.around(); ++i)
      EXPECT_GT(
          colorAt(at(2 * pi * (i + 0.5) / graticule.around(), pi * 3.5 / 8), spacing, graticule)
              .minCoeff(),
          240);
  }
}

TEST(SpherePattern, StripesAreAsWideAsTheVerticesAreApart) {
  // However the vertices fall, one of them shows the line all but fully.
  const SpherePatternParameters graticule{SpherePattern::Graticule, 8};
  const double spacing = 0.1;
  for (double offset = 0; offset < 1; offset += 0.1) {
    int darkest = 255;
    for (int i = -2; i <= 2; ++i)
      darkest = std::min(
          darkest, colorAt(at(1, pi / 2 + (i + offset) * spacing), spacing, graticule).maxCoeff());
    EXPECT_LT(darkest, 130);
  }
}

TEST(SpherePattern, RefusesCellsOutOfRange) {
  for (const int cells : {-1, 0, 1, maxPatternCells + 1})
    EXPECT_THROW(colorAt({0, 0, 1}, 0, {SpherePattern::Checkerboard, cells}), ParameterError);
  EXPECT_NO_THROW(colorAt({0, 0, 1}, 0, {SpherePattern::Checkerboard, maxPatternCells}));
}

TEST(SpherePattern, SpacingIsTheMeanEdge) {
  const Mesh octa = octahedron(), tetra = tetrahedron();
  EXPECT_TRUE(sphereSpacing(octa.vertices, octa.faces).isApproxToConstant(pi / 2, 1e-14));
  EXPECT_TRUE(
      sphereSpacing(tetra.vertices, tetra.faces).isApproxToConstant(std::acos(-1.0 / 3), 1e-14));
}

TEST(SpherePattern, AreaRatiosAreGreyAtOneAndSymmetricInTheLogarithm) {
  Eigen::VectorXd ratios(9);
  ratios << 1, 2, 0.5, 5, 0.2, std::sqrt(2), 1 / std::sqrt(2), 0, 1e300;
  const Eigen::Matrix<int, Eigen::Dynamic, 3> c = areaRatioColors(ratios, 2).cast<int>();
  EXPECT_EQ(c(0, 0), c(0, 1));
  EXPECT_EQ(c(0, 1), c(0, 2));
  EXPECT_GT(c(1, 0), c(1, 2) + 100);  // red
  EXPECT_GT(c(2, 2), c(2, 0) + 100);  // blue
  EXPECT_EQ(c.row(3), c.row(1));
  EXPECT_EQ(c.row(4), c.row(2));
  EXPECT_EQ(c.row(7), c.row(2));
  EXPECT_EQ(c.row(8), c.row(1));
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(c(5, k), (c(0, k) + c(1, k)) / 2.0, 1);
    EXPECT_NEAR(c(6, k), (c(0, k) + c(2, k)) / 2.0, 1);
  }
  for (const double limit : {1.0, 0.5, 0.0, -2.0, std::nan(""), HUGE_VAL})
    EXPECT_THROW(areaRatioColors(ratios, limit), ParameterError);
}

}  // namespace
}  // namespace sphere_propagation::test
