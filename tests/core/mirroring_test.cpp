// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/mirroring.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "tests/core/test_meshes.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

ThreadPool pool(2);

/// A shape without any plane of symmetry, which shrinks a little from phase to phase, each in a
/// mesh of its own.
ClosedSurface phaseOf(int phase, bool mirrored = false) {
  test::Mesh mesh = test::transformed(test::icosphereMesh(9 + phase % 2),
                                      test::randomRotation(20 + phase), 1, Vector3::Zero());
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    const Vector3 d = mesh.vertices.row(v).transpose();
    mesh.vertices.row(v) *= 1 + 0.5 * std::exp(-4 * (d - Vector3(0.6, 0.64, 0.48)).squaredNorm()) +
                            0.4 * std::exp(-6 * (d - Vector3(-0.48, 0.6, 0.64)).squaredNorm());
  }
  mesh.vertices *= (1 - 0.02 * phase) * Vector3(40, 30, 22).asDiagonal();
  return surfaceOf(mirrored ? test::mirrored(mesh) : mesh);
}

/// 'r' and 'l' for each layer.
std::vector<ClosedSurface> sides(const std::string& text) {
  std::vector<ClosedSurface> surfaces;
  for (size_t i = 0; i < text.size(); ++i)
    surfaces.push_back(phaseOf(static_cast<int>(i), text[i] == 'l'));
  return surfaces;
}

std::string found(const std::string& text, const PropagationTree& tree) {
  std::string answer;
  for (const std::optional<double>& plane : findMirrorPlanes(sides(text), tree, pool))
    answer += plane ? 'm' : '-';
  return answer;
}

TEST(Mirroring, TheImageIsOutwardAndTwiceIsNothing) {
  const ClosedSurface surface = phaseOf(0), image = mirrorImage(surface, 3);
  EXPECT_EQ(image.vertices().col(0), (6 - surface.vertices().col(0).array()).matrix());
  EXPECT_EQ(image.vertices().rightCols(2), surface.vertices().rightCols(2));
  EXPECT_NEAR(enclosedVolume(image.vertices(), image.faces()),
              enclosedVolume(surface.vertices(), surface.faces()), 1e-8);
  const ClosedSurface again = mirrorImage(image, 3);
  EXPECT_LT((again.vertices() - surface.vertices()).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_EQ(again.faces(), surface.faces());
}

TEST(Mirroring, OnlyWhatDiffersFromTheRoot) {
  EXPECT_EQ(found("rrrr", timeOrder(4, 0)), "----");
  EXPECT_EQ(found("rrlr", star(4, 0)), "--m-");
  EXPECT_EQ(found("lrrr", star(4, 0)), "-mmm");  // the root tells which side it is
  EXPECT_EQ(found("rlrl", star(4, 2)), "-m-m");
}

TEST(Mirroring, AlongAChainEachIsComparedWithItsParentAsItWillBe) {
  EXPECT_EQ(found("rrlr", timeOrder(4, 0)), "--m-");  // the one behind the left one is right
  EXPECT_EQ(found("rllr", timeOrder(4, 0)), "-mm-");
  EXPECT_EQ(found("rlll", timeOrder(4, 0)), "-mmm");
}

TEST(Mirroring, ThePlanePassesThroughTheCentroidOfTheArea) {
  const std::vector<ClosedSurface> surfaces = sides("rl");
  const auto planes = findMirrorPlanes(surfaces, star(2, 0), pool);
  ASSERT_TRUE(planes[1]);
  const Points& p = surfaces[1].vertices();
  const Triangles& faces = surfaces[1].faces();
  double moment = 0, area = 0;
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const double a = faceAreas(p, faces.row(f))[0];
    moment += a * (p(faces(f, 0), 0) + p(faces(f, 1), 0) + p(faces(f, 2), 0)) / 3;
    area += a;
  }
  EXPECT_NEAR(*planes[1], moment / area, 1e-10);
}

}  // namespace
}  // namespace sphere_propagation
