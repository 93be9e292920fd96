// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/mesh/icosphere.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "tests/core/test_meshes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/sphere/certificate.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation::test {
namespace {

TEST(Icosphere, CountsAndTopology) {
  for (const int f : {1, 2, 3, 4, 7, 10, 33}) {
    const Icosphere sphere = icosphere(f);
    EXPECT_EQ(sphere.vertices.rows(), 10 * f * f + 2);
    EXPECT_EQ(sphere.faces.rows(), 20 * f * f);
    const ClosedSurface surface(sphere.vertices,
                                sphere.faces);  // throws unless closed, outward, of genus 0
    const MappedSurface map(surface, sphere.vertices);
    int five = 0;
    for (int v = 0; v < surface.vertexCount(); ++v) {
      const int valence = surface.ring(v).size();
      EXPECT_TRUE(valence == 5 || valence == 6);
      five += valence == 5;
    }
    EXPECT_EQ(five, 12);
  }
  EXPECT_EQ(icosphere(10).vertices.rows(), 1002);
}

TEST(Icosphere, IsTheSubdividedIcosahedron) {
  // The slow construction of the tests, turned so that it stands on the same corner and the same
  // edge.
  for (const int f : {1, 2, 5}) {
    const Icosphere sphere = icosphere(f);
    const Icosphere base = icosphere(1);
    const Mesh plain = icosahedron();
    Eigen::Matrix3d from, to;
    from << plain.vertices.row(0).transpose(), plain.vertices.row(11).transpose(),
        plain.vertices.row(5).transpose();
    to << base.vertices.row(0).transpose(), base.vertices.row(1).transpose(),
        base.vertices.row(2).transpose();
    const Mesh slow = transformed(icosphereMesh(f), to * from.inverse(), 1, Vector3::Zero());
    for (Eigen::Index v = 0; v < sphere.vertices.rows(); ++v) {
      const double distance =
          (slow.vertices.rowwise() - sphere.vertices.row(v)).rowwise().norm().minCoeff();
      EXPECT_LT(distance, 1e-14) << "frequency " << f << ", vertex " << v;
    }
  }
}

TEST(Icosphere, Regularity) {
  for (const int f : {1, 2, 5, 10, 20}) {
    const Icosphere sphere = icosphere(f);
    EXPECT_LT((sphere.vertices.rowwise().norm().array() - 1).abs().maxCoeff(), 1e-15);
    EXPECT_LT(sphere.vertices.colwise().mean().norm(), 1e-15);
    double shortest = 9, longest = 0;
    for (Eigen::Index t = 0; t < sphere.faces.rows(); ++t)
      for (int k = 0; k < 3; ++k) {
        const double length = (sphere.vertices.row(sphere.faces(t, k)) -
                               sphere.vertices.row(sphere.faces(t, (k + 1) % 3)))
                                  .norm();
        shortest = std::min(shortest, length);
        longest = std::max(longest, length);
      }
    if (f == 1)
      EXPECT_NEAR(longest / shortest, 1, 1e-14);
    else
      EXPECT_LT(longest / shortest, 1.53);
    const Eigen::VectorXd areas = faceAreas(sphere.vertices, sphere.faces);
    EXPECT_LT(areas.maxCoeff() / areas.minCoeff(), 2.03);
  }
}

TEST(Icosphere, RowsRunFromPoleToPole) {
  for (const int f : {1, 3, 10}) {
    const Icosphere sphere = icosphere(f);
    const Eigen::Index last = sphere.vertices.rows() - 1;
    EXPECT_EQ(sphere.vertices.row(0), Eigen::RowVector3d(0, 0, 1));
    EXPECT_EQ(sphere.vertices.row(last), Eigen::RowVector3d(0, 0, -1));
    // Neighbours' numbers differ by at most two rows.
    for (Eigen::Index t = 0; t < sphere.faces.rows(); ++t)
      EXPECT_LE(sphere.faces.row(t).maxCoeff() - sphere.faces.row(t).minCoeff(), 10 * f - 1);
    // Within a row the longitude grows; where it falls a row begins, and there are 3 f + 1 of them.
    int rows = 1;
    double before = -1;
    for (Eigen::Index v = 1; v < last; ++v) {
      double longitude = std::atan2(sphere.vertices(v, 1), sphere.vertices(v, 0));
      if (longitude < -1e-9) longitude += 2 * 3.14159265358979323846;
      rows += longitude < before;
      before = longitude;
    }
    EXPECT_EQ(rows + 2, 3 * f + 1);
  }
}

TEST(Icosphere, Nested) {
  // Row by row as documented.
  const int f = 3, k = 4;
  const Icosphere coarse = icosphere(f), fine = icosphere(k * f);
  const auto rowStarts = [](int frequency) {
    std::vector<int> starts{0};
    for (int row = 0; row <= 3 * frequency; ++row) {
      const int size = row == 0 || row == 3 * frequency
                           ? 1
                           : 5 * std::min({row, frequency, 3 * frequency - row});
      starts.push_back(starts.back() + size);
    }
    return starts;
  };
  const std::vector<int> from = rowStarts(f), to = rowStarts(k * f);
  ASSERT_EQ(from.back(), coarse.vertices.rows());
  for (int row = 0; row <= 3 * f; ++row)
    for (int s = 0; from[row] + s < from[row + 1]; ++s)
      EXPECT_LT(
          (coarse.vertices.row(from[row] + s) - fine.vertices.row(to[k * row] + k * s)).norm(),
          1e-15);
}

TEST(Icosphere, IsRecognisedByItsFaces) {
  for (const int f : {1, 2, 10}) {
    const Icosphere sphere = icosphere(f);
    EXPECT_EQ(icosphereFrequency(sphere.vertices.rows(), sphere.faces), f);
    EXPECT_EQ(icosphereFrequency(sphere.vertices.rows() + 1, sphere.faces), std::nullopt);
    EXPECT_EQ(icosphereFrequency(sphere.vertices.rows(), sphere.faces.topRows(20 * f * f - 1)),
              std::nullopt);
    Triangles other = sphere.faces;
    std::swap(other(20 * f * f - 1, 0), other(20 * f * f - 1, 2));
    EXPECT_EQ(icosphereFrequency(sphere.vertices.rows(), other), std::nullopt);
  }
  EXPECT_EQ(icosphereFrequency(12, icosahedron().faces), std::nullopt);
  EXPECT_EQ(icosphereFrequency(0, Triangles(0, 3)), std::nullopt);
  EXPECT_EQ(icosphereFrequency(642, noisyEllipsoid(1).faces), std::nullopt);
}

TEST(Icosphere, FrequencyOutOfRange) {
  for (const int f : {0, -1, maxIcosphereFrequency + 1, 1 << 30})
    EXPECT_THROW(icosphere(f), ParameterError);
  try {
    icosphere(2000);
    FAIL();
  } catch (const ParameterError& error) {
    EXPECT_NE(std::string(error.what()).find("40000002 landmarks"), std::string::npos)
        << error.what();
    EXPECT_NE(std::string(error.what()).find("1920 MB"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace sphere_propagation::test
