// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/ventricle_phantom.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "tests/core/sizes.h"
#include "tests/core/test_meshes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

using test::pi;
using Part = PhantomParameters::Part;

VentriclePhantom phantom(Part part, unsigned seed = 0, double twist = 0, double voxelSize = 2,
                         int phases = 25) {
  return VentriclePhantom({part, phases, voxelSize, twist, seed});
}

/// Volume inside the sheet m between the apex and the height `top`, by slices: the area of the
/// outline at each height.
double analyticVolume(const VentriclePhantom& ventricle, double phase, double m, double top) {
  const int rows = test::sizeFor(400, 100), columns = rows;
  double volume = 0, before = 0, heightBefore = ventricle.position(0, 0, phase, m)[2];
  for (int r = 1; r < rows; ++r) {
    const double u = static_cast<double>(r) / (rows - 1);
    double area = 0, height = 0;
    for (int c = 0; c < columns; ++c) {
      const Vector3 p = ventricle.position(u, 2 * pi * c / columns, phase, m);
      const Vector3 q = ventricle.position(u, 2 * pi * (c + 1) / columns, phase, m);
      area += (p[0] * q[1] - p[1] * q[0]) / 2;
      height += p[2] / columns;
    }
    const double end = std::min(height, top);
    if (end <= heightBefore) break;
    volume += (area + before) / 2 * (end - heightBefore);
    before = area;
    heightBefore = height;
  }
  return volume;
}

TEST(VentriclePhantom, IsThatOfThePythonYardstick) {
  // from phantom import Ventricle
  // for seed, part, twist in ((0, "cavity", 0.0), (7, "wall", 20.0)):
  //     v = Ventricle(part, seed, twist=twist)
  //     for a in ((0, 0, 0, 0), (0.3, 1.2, 7, 0.4), (1, 6.1, 13.5, 1), (0.52, 3.7, 9, 1)):
  //     print(v.position(*a).tolist())
  const double arguments[4][4] = {
      {0, 0, 0, 0}, {0.3, 1.2, 7, 0.4}, {1, 6.1, 13.5, 1}, {0.52, 3.7, 9, 1}};
  const Vector3 expected[2][4] = {{{-0.08083658213963361, 0.0, -44.88034585840789},
                                   {3.9641432705914017, 12.305437824877153, -35.70660914366952},
                                   {29.340270280108864, -6.140902576280614, 19.18736356249602},
                                   {-25.405055819749915, -17.591864836608252, -24.149707957644512}},
                                  {{0.796986146769044, 0.0, -42.97493778481017},
                                   {4.356855568850283, 13.982217033247078, -34.33784049856105},
                                   {31.719799830725297, -5.447624780715315, 18.5266516535948},
                                   {-14.264207469906527, -17.790746289981666, -24.99936873615899}}};
  for (int s = 0; s < 2; ++s) {
    const VentriclePhantom ventricle =
        s == 0 ? phantom(Part::Cavity, 0) : phantom(Part::Wall, 7, 20);
    for (int i = 0; i < 4; ++i) {
      const auto& a = arguments[i];
      EXPECT_LT((ventricle.position(a[0], a[1], a[2], a[3]) - expected[s][i]).norm(), 1e-12)
          << s << " " << i;
    }
  }
}

TEST(VentriclePhantom, HasTheVoxelsAndMeshesOfThePythonYardstick) {
  // for part, seed, t in (("cavity", 0, 0), ("wall", 7, 9)):
  //     v = Ventricle(part, seed, voxel=2.0); m, low, h = v.mask(t); x, f = v.mesh(t)
  //     print(m.shape, m.sum(), low.tolist(), len(x), len(f), x.mean(0).tolist())
  struct Expected {
    Part part;
    unsigned seed;
    int phase;
    Eigen::Vector3i size;
    long voxels;
    Vector3 low;
    long vertices, faces;
    Vector3 mean;
  };
  const Expected cases[] = {{Part::Cavity,
                             0,
                             0,
                             {46, 45, 46},
                             13632,
                             {-44.10318938, -42.56673026, -60.98034586},
                             4010,
                             8016,
                             {0.25996283, 0.16495063, -8.69208204}},
                            {Part::Wall,
                             7,
                             9,
                             {39, 42, 43},
                             11420,
                             {-30.31616002, -40.52698238, -55.84583427},
                             5984,
                             11964,
                             {6.38499042, -0.06634587, -13.78556608}}};
  for (const Expected& expected : cases) {
    const VentriclePhantom ventricle = phantom(expected.part, expected.seed);
    const ScalarGrid mask = ventricle.mask(expected.phase);
    EXPECT_EQ(mask.size, expected.size);
    EXPECT_EQ(std::count(mask.values.begin(), mask.values.end(), 1.0F), expected.voxels);
    EXPECT_EQ(std::count(mask.values.begin(), mask.values.end(), 0.0F),
              static_cast<long>(mask.values.size()) - expected.voxels);
    EXPECT_LT((mask.origin - expected.low).norm(), 1e-7);
    const PhantomMesh mesh = ventricle.mesh(expected.phase);
    EXPECT_EQ(mesh.vertices.rows(), expected.vertices);
    EXPECT_EQ(mesh.faces.rows(), expected.faces);
    EXPECT_LT((mesh.vertices.colwise().mean().transpose() - expected.mean).norm(), 1e-5);
  }
}

TEST(VentriclePhantom, IsClosedOfGenusZeroInEveryPhase) {
  for (const Part part : {Part::Cavity, Part::Wall})
    for (int seed = 0; seed < test::sizeFor(6, 1); ++seed) {
      const VentriclePhantom ventricle = phantom(part, static_cast<unsigned>(seed));
      for (int phase = 0; phase < 25; phase += seed == 0 ? test::sizeFor(1, 12) : 9) {
        const PhantomMesh mesh = ventricle.mesh(phase);
        EXPECT_NO_THROW(ClosedSurface(mesh.vertices, mesh.faces))
            << "seed " << seed << ", phase " << phase;
      }
    }
}

TEST(VentriclePhantom, HasTheAnalyticVolume) {
  for (const unsigned seed : {0U, 3U})
    for (const int phase : {0, 9, 17}) {
      if (test::underSanitizer() && (seed != 0 || phase != 9)) continue;
      const VentriclePhantom cavity = phantom(Part::Cavity, seed), wall = phantom(Part::Wall, seed);
      const PhantomMesh blood = cavity.mesh(phase), muscle = wall.mesh(phase);
      // Up to where the voxels end: they cut the base at the nearest slice.
      const double bloodTop = blood.vertices.col(2).maxCoeff(),
                   muscleTop = muscle.vertices.col(2).maxCoeff();
      const double rim = cavity.position(1, 0, phase, 0)[2];
      EXPECT_LT(std::fabs(bloodTop - rim), 1.01);
      const double expectedBlood = analyticVolume(cavity, phase, 0, bloodTop);
      const double expectedMuscle =
          analyticVolume(wall, phase, 1, muscleTop) - analyticVolume(wall, phase, 0, muscleTop);
      EXPECT_NEAR(enclosedVolume(blood.vertices, blood.faces) / expectedBlood, 1, 0.02);
      EXPECT_NEAR(enclosedVolume(muscle.vertices, muscle.faces) / expectedMuscle, 1, 0.02);
    }
}

TEST(VentriclePhantom, BeatsAsItShould) {
  const VentriclePhantom ventricle = phantom(Part::Cavity);
  std::vector<double> volumes;
  for (int phase = 0; phase < 25; ++phase) {
    const ScalarGrid mask = ventricle.mask(phase);
    volumes.push_back(
        static_cast<double>(std::count(mask.values.begin(), mask.values.end(), 1.0F)));
  }
  EXPECT_EQ(std::max_element(volumes.begin(), volumes.end()) - volumes.begin(), 0);
  EXPECT_NEAR(
      static_cast<double>(std::min_element(volumes.begin(), volumes.end()) - volumes.begin()),
      0.35 * 25, 1);
  EXPECT_NEAR(*std::min_element(volumes.begin(), volumes.end()) / volumes[0], 0.4,
              0.1);  // ejection fraction 0.6
  // The cycle is closed, and takes as long as it has phases.
  const VentriclePhantom slow = phantom(Part::Cavity, 0, 0, 2, 50);
  for (int phase = 0; phase < 25; ++phase)
    EXPECT_LT(
        (slow.position(0.4, 2, 2 * phase, 0.5) - ventricle.position(0.4, 2, phase, 0.5)).norm(),
        1e-12);
  EXPECT_LT((ventricle.position(0.4, 2, 25 - 1e-9, 0) - ventricle.position(0.4, 2, 0, 0)).norm(),
            1e-6);
}

TEST(VentriclePhantom, KnowsItsMaterialPoints) {
  for (const Part part : {Part::Cavity, Part::Wall})
    for (const unsigned seed : {0U, 1U})
      for (const int phase : {0, 9, 20}) {
        if (test::underSanitizer() && (seed != 1 || phase != 9)) continue;
        const double voxel = 2;
        const VentriclePhantom ventricle = phantom(part, seed, 15, voxel);
        const PhantomMesh mesh = ventricle.mesh(phase);
        ASSERT_EQ(mesh.materialCoordinates.rows(), mesh.vertices.rows());
        const double rim = mesh.vertices.col(2).maxCoeff() - 2 * voxel;
        std::vector<double> distances;
        int lid = 0;
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
          const Eigen::RowVector3d material = mesh.materialCoordinates.row(v);
          ASSERT_GE(material[0], 0);
          ASSERT_LE(material[0], part == Part::Cavity ? 2 : 1);
          ASSERT_GE(material[1], 0);
          ASSERT_LT(material[1], 2 * pi);
          ASSERT_GE(material[2], 0);
          ASSERT_LE(material[2], part == Part::Cavity ? 0 : 1);
          const bool onLid =
              part == Part::Cavity ? material[0] > 1.2 : material[2] > 0.2 && material[2] < 0.8;
          lid += onLid;
          if (mesh.vertices(v, 2) < rim || onLid)
            distances.push_back((ventricle.position(material[0], material[1], phase, material[2]) -
                                 mesh.vertices.row(v).transpose())
                                    .norm());
        }
        std::sort(distances.begin(), distances.end());
        EXPECT_GT(lid, 30);
        // The mask stacks outlines at the mean height of each circle of equal u; the wall's outer
        // circles are not level beside the infarct, and there a few vertices are further away.
        const double share = part == Part::Cavity ? 1 : 0.98;
        EXPECT_LT(distances[static_cast<size_t>(share * static_cast<double>(distances.size() - 1))],
                  voxel / 2);
        EXPECT_LT(distances.back(), part == Part::Cavity ? voxel / 2 : voxel);
        EXPECT_LT(std::accumulate(distances.begin(), distances.end(), 0.0) /
                      static_cast<double>(distances.size()),
                  0.15 * voxel);
      }
}

TEST(VentriclePhantom, FindsTheClosestPoint) {
  // No other material point close by is closer to the vertex than the one that was given to it.
  const VentriclePhantom ventricle = phantom(Part::Wall, 2);
  const PhantomMesh mesh = ventricle.mesh(5);
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); v += 37) {
    const Eigen::RowVector3d q = mesh.materialCoordinates.row(v);
    if (q[2] > 0 && q[2] < 1) continue;  // on the cut, whose u is not free
    const auto distance = [&](double u, double theta) {
      return (ventricle.position(u, theta, 5, q[2]) - mesh.vertices.row(v).transpose()).norm();
    };
    for (const double du : {-0.02, 0.02})
      EXPECT_GT(distance(q[0] + du, q[1]), distance(q[0], q[1]) - 0.02);
    for (const double dtheta : {-0.05, 0.05})
      EXPECT_GT(distance(q[0], q[1] + dtheta), distance(q[0], q[1]) - 0.02);
  }
}

TEST(VentriclePhantom, HasALidThatContinuesTheCavity) {
  const VentriclePhantom ventricle = phantom(Part::Cavity, 4);
  for (const double theta : {0.0, 1.0, 4.0}) {
    const Vector3 rim = ventricle.position(1, theta, 6, 0),
                  centre = ventricle.position(2, theta, 6, 0);
    EXPECT_LT((ventricle.position(1 + 1e-9, theta, 6, 0) - rim).norm(), 1e-6);
    EXPECT_LT((ventricle.position(1.25, theta, 6, 0) - (0.75 * rim + 0.25 * centre)).norm(), 1e-12);
    EXPECT_LT((centre - ventricle.position(2, 0, 6, 0)).norm(), 1e-12);
  }
}

TEST(VentriclePhantom, RefusesWhatItsHeaderExcludes) {
  EXPECT_THROW(phantom(Part::Cavity, 0, 0, 2, 0), ParameterError);
  EXPECT_THROW(phantom(Part::Cavity, 0, 0, 0.1), ParameterError);
  EXPECT_THROW(phantom(Part::Cavity, 0, 0, std::numeric_limits<double>::quiet_NaN()),
               ParameterError);
  EXPECT_THROW(phantom(Part::Cavity, 0, 1000), ParameterError);
  EXPECT_THROW(phantom(Part::Cavity).mesh(25), ParameterError);
  EXPECT_THROW(phantom(Part::Cavity).mask(-1), ParameterError);
}

}  // namespace
}  // namespace sphere_propagation
