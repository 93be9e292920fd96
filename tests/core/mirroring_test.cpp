// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/mirroring.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "tests/core/sizes.h"
#include "tests/core/test_meshes.h"
#include "tests/core/test_pool.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

using test::pool;
using test::sizeFor;
using test::underSanitizer;

/// A shape without any plane of symmetry, which shrinks a little from phase to phase, each in a
/// mesh of its own.
ClosedSurface phaseOfHand(int phase, bool mirrored = false) {
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
    surfaces.push_back(phaseOfHand(static_cast<int>(i), text[i] == 'l'));
  return surfaces;
}

std::string found(const std::string& text, const PropagationTree& tree) {
  std::string answer;
  for (const SurfaceSide& side : findSides(sides(text), tree, pool).surfaces)
    answer += side.mirrored ? 'm' : side.known ? '-' : '?';
  return answer;
}

TEST(Mirroring, TheImageIsOutwardAndTwiceIsNothing) {
  const ClosedSurface surface = phaseOfHand(0), image = mirrorImage(surface, 3);
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

TEST(Mirroring, AlongAChainTheRootTells) {
  EXPECT_EQ(found("rrlr", timeOrder(4, 0)), "--m-");
  EXPECT_EQ(found("rllr", timeOrder(4, 0)), "-mm-");
  EXPECT_EQ(found("rlll", timeOrder(4, 0)), "-mmm");
}

TEST(Mirroring, OfTwoTheRootTells) {
  EXPECT_EQ(found("rl", timeOrder(2, 0)), "-m");
  EXPECT_EQ(found("rl", timeOrder(2, 1)), "m-");
  EXPECT_EQ(found("rr", timeOrder(2, 0)), "--");
}

TEST(Mirroring, AMirroredLayerMayLieElsewhere) {
  std::vector<ClosedSurface> surfaces = sides("rrlrr");
  for (const size_t i : {2, 3})
    surfaces[i] = surfaceOf(test::transformed({surfaces[i].vertices(), surfaces[i].faces()},
                                              test::randomRotation(i), 1, Vector3(300, -20, 40)));
  const std::vector<SurfaceSide> found = findSides(surfaces, timeOrder(5, 0), pool).surfaces;
  for (size_t i = 0; i < 5; ++i) EXPECT_EQ(found[i].mirrored, i == 2) << i;
}

TEST(Mirroring, WhatIsItsOwnMirrorImageIsNotKnown) {
  std::vector<ClosedSurface> surfaces;
  for (int i = 0; i < 5; ++i) {
    test::Mesh mesh =
        test::transformed(test::icosphereMesh(8), test::randomRotation(i), 1, Vector3::Zero());
    mesh.vertices *= Vector3(30, 20 - i, 15).asDiagonal();
    surfaces.push_back(surfaceOf(mesh));
  }
  for (const PropagationTree& tree : {timeOrder(5, 0), star(5, 2)}) {
    const std::vector<SurfaceSide> sides = findSides(surfaces, tree, pool).surfaces;
    for (size_t i = 0; i < 5; ++i) {
      EXPECT_FALSE(sides[i].mirrored || sides[i].inDoubt) << i;
      EXPECT_EQ(sides[i].known, static_cast<int>(i) == tree.root()) << i;
    }
  }
}

TEST(Mirroring, ReflectedAcrossThePlaneThroughTheCentroidOfTheArea) {
  const std::vector<ClosedSurface> surfaces = sides("rl");
  const ReflectedSequence reflected = reflectMirrorImages(surfaces, {}, 0, pool);
  ASSERT_TRUE(reflected.planes[1]);
  EXPECT_FALSE(reflected.planes[0]);
  const Points& p = surfaces[1].vertices();
  const Triangles& faces = surfaces[1].faces();
  double moment = 0, area = 0;
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const double a = faceAreas(p, faces.row(f))[0];
    moment += a * (p(faces(f, 0), 0) + p(faces(f, 1), 0) + p(faces(f, 2), 0)) / 3;
    area += a;
  }
  EXPECT_NEAR(*reflected.planes[1], moment / area, 1e-10);
  const ReflectedSequence looked = reflectMirrorImages(surfaces, {}, 0, pool, false);
  EXPECT_TRUE(looked.sides.surfaces[1].mirrored);
  EXPECT_FALSE(looked.planes[1]);
  EXPECT_EQ(looked.sequence.surface(1).vertices(), surfaces[1].vertices());
}

TEST(Mirroring, InAnotherUnitItIsFoundAsWell) {
  std::vector<ClosedSurface> surfaces = sides("rrlr");
  surfaces[2] = surfaces[2].withVertices(surfaces[2].vertices() / 10);
  EXPECT_TRUE(reflectMirrorImages(surfaces, {}, 0, pool).sides.surfaces[2].mirrored);
}

/// A subject: an ellipsoid with bumps of its own at random places, and those of the hand where the
/// shape is to have a side.
ClosedSurface subject(int seed, double side, bool mirrored = false, int frequency = 9) {
  test::Random random(static_cast<unsigned>(seed));
  test::Mesh mesh = test::transformed(test::icosphereMesh(frequency), test::randomRotation(seed), 1,
                                      Vector3::Zero());
  Points own(4, 3);
  Eigen::Vector4d heights;
  for (int k = 0; k < 4; ++k) {
    own.row(k) = random.direction().transpose();
    heights[k] = 0.12 * random.normal();
  }
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    const Vector3 d = mesh.vertices.row(v).transpose();
    double height = 1 + side * (0.5 * std::exp(-4 * (d - Vector3(0.6, 0.64, 0.48)).squaredNorm()) +
                                0.4 * std::exp(-6 * (d - Vector3(-0.48, 0.6, 0.64)).squaredNorm()));
    for (int k = 0; k < 4; ++k)
      height += heights[k] * std::exp(-4 * (d - own.row(k).transpose()).squaredNorm());
    mesh.vertices.row(v) *= height;
  }
  mesh.vertices *= Vector3(40, 30, 22).asDiagonal();
  return surfaceOf(mirrored ? test::mirrored(mesh) : mesh);
}

std::string foundOfSubjects(int firstSeed, double side, int mirrored, int count = 8) {
  std::vector<ClosedSurface> surfaces;
  for (int i = 0; i < count; ++i) surfaces.push_back(subject(firstSeed + i, side, i == mirrored));
  std::string answer;
  for (const SurfaceSide& found : findSides(surfaces, star(count, 0), pool).surfaces)
    answer += found.mirrored ? 'm' : found.inDoubt ? '!' : '-';
  return answer;
}

TEST(Mirroring, OfSubjectsWithAnAsymmetryOfTheirOwnNoneIsCalledMirrored) {
  for (int seed = 0; seed < sizeFor(400, 100); seed += 100) {
    EXPECT_EQ(foundOfSubjects(seed, 0, -1), "--------") << seed;
    EXPECT_EQ(foundOfSubjects(seed, 0, 3), "--------") << seed;  // nobody could tell
  }
}

TEST(Mirroring, OfSubjectsWithASideTheMirroredOneIsFound) {
  for (int seed = 0; seed < sizeFor(400, 100); seed += 100) {
    EXPECT_EQ(foundOfSubjects(seed, 1, -1), "--------") << seed;
    EXPECT_EQ(foundOfSubjects(seed, 1, 3), "---m----") << seed;
  }
}

/// 8 subjects of which number 5 is number 2 once more, mirrored, elsewhere and, where asked for, in
/// another mesh.
std::vector<ClosedSurface> withExactImage(bool anotherMesh = false) {
  std::vector<ClosedSurface> surfaces;
  for (int i = 0; i < 8; ++i) surfaces.push_back(subject(500 + i, 0));
  if (anotherMesh) surfaces[2] = subject(502, 0, false, 25);
  const ClosedSurface image = subject(502, 0, true, anotherMesh ? 20 : 9);
  surfaces[5] = surfaceOf(test::transformed({image.vertices(), image.faces()},
                                            test::randomRotation(7), 1, Vector3(80, -9, 30)));
  return surfaces;
}

TEST(Mirroring, AnExactImageIsNamedWhateverElseThereIs) {
  for (const bool anotherMesh : {false, true}) {
    const std::vector<ClosedSurface> surfaces = withExactImage(anotherMesh);
    const SurfaceSides found = findSides(surfaces, star(8, 0), pool);
    for (size_t i = 0; i < 8; ++i) {
      EXPECT_EQ(found.surfaces[i].imageOf, i == 5 ? 2 : -1) << i;
      EXPECT_FALSE(found.surfaces[i].mirrored) << i;  // which of the two it is nobody knows
    }
    const SurfaceSides ofRoot = findSides(surfaces, star(8, 2), pool);
    for (size_t i = 0; i < 8; ++i) EXPECT_EQ(ofRoot.surfaces[i].mirrored, i == 5) << i;
  }
}

TEST(Mirroring, OfTwoExactImagesTheRootTells) {
  const std::vector<ClosedSurface> surfaces{subject(500, 0), mirrorImage(subject(500, 0), 7)};
  const SurfaceSides found = findSides(surfaces, timeOrder(2, 0), pool);
  EXPECT_TRUE(found.surfaces[1].mirrored);
  EXPECT_EQ(found.surfaces[1].imageOf, 0);
  EXPECT_FALSE(found.noSide);
}

TEST(Mirroring, ACopyOfTheSameSideIsNoImage) {
  std::vector<ClosedSurface> surfaces = withExactImage();
  surfaces[5] = mirrorImage(surfaces[5]);
  for (const SurfaceSide& side : findSides(surfaces, star(8, 0), pool).surfaces)
    EXPECT_EQ(side.imageOf, -1);
}

TEST(Mirroring, WithoutASideInCommonNobodyCanTell) {
  std::vector<ClosedSurface> surfaces;
  for (int i = 0; i < 8; ++i) surfaces.push_back(subject(100 + i, 0));
  const SurfaceSides without = findSides(surfaces, star(8, 0), pool);
  ASSERT_TRUE(without.noSide);
  EXPECT_LT(*without.noSide, 0.5);
  for (size_t i = 1; i < 8; ++i) EXPECT_FALSE(without.surfaces[i].known) << i;
  surfaces.clear();
  for (int i = 0; i < 8; ++i) surfaces.push_back(subject(100 + i, 1, i == 3));
  EXPECT_FALSE(findSides(surfaces, star(8, 0), pool).noSide);
}

std::vector<ClosedSurface> twelveSubjects(int firstSeed, double side, int mirrored) {
  std::vector<ClosedSurface> surfaces;
  for (int i = 0; i < 12; ++i) surfaces.push_back(subject(firstSeed + i, side, i == mirrored));
  return surfaces;
}

/// Of 12 subjects: which are named, and which are doubtful.
std::string doubtsOf(int firstSeed, double side, int mirrored) {
  std::string answer;
  for (const SurfaceSide& found :
       findSides(twelveSubjects(firstSeed, side, mirrored), star(12, 0), pool).surfaces)
    answer += found.mirrored ? 'm' : found.isDoubtful() ? 'd' : '-';
  return answer;
}

TEST(Mirroring, OfTwelveSubjectsWithAWeakSideTheOddOneIsDoubtful) {
  EXPECT_EQ(doubtsOf(200, 0.4, 3), "---d--------");
  if (underSanitizer()) return;
  EXPECT_EQ(doubtsOf(200, 0, -1), "------------");
  EXPECT_EQ(doubtsOf(200, 0.4, -1), "------------");
}

/// Of subjects whose sides, images and doubts are looked for. Under sanitizers threads run, and are
/// not compared.
TEST(Mirroring, IsTheSameWithAnyNumberOfThreads) {
  std::vector<ClosedSurface> surfaces = twelveSubjects(200, 0.4, 3);
  surfaces[7] = mirrorImage(surfaces[5], 2);
  const auto foundBy = [&](int threads) {
    ThreadPool several(threads);
    std::ostringstream text;
    text.precision(17);
    for (const SurfaceSide& side : findSides(surfaces, star(12, 0), several).surfaces)
      text << side.mirrored << side.known << side.inDoubt << ' ' << side.imageOf << ' '
           << side.against << ' ' << side.compared << '\n';
    return text.str();
  };
  const std::string found = foundBy(3);
  EXPECT_NE(found.find(" 5 "), std::string::npos) << found;  // the image
  if (underSanitizer()) return;
  for (const int threads : {1, 2, 8}) EXPECT_EQ(foundBy(threads), found);
}

/// Evidence of pairs, given below the diagonal.
Eigen::MatrixXd evidenceOf(int count, const std::vector<double>& below) {
  Eigen::MatrixXd evidence = Eigen::MatrixXd::Zero(count, count);
  size_t next = 0;
  for (int i = 1; i < count; ++i)
    for (int j = 0; j < i; ++j) evidence(i, j) = evidence(j, i) = below[next++];
  return evidence;
}

std::string decided(const Eigen::MatrixXd& evidence) {
  std::string answer;
  for (const SurfaceSide& side : sidesFromEvidence(evidence, 0))
    answer += side.mirrored ? 'm' : side.known ? '-' : side.inDoubt ? '!' : '?';
  return answer;
}

TEST(Mirroring, AllPairsThatSaySomethingDecide) {
  EXPECT_EQ(decided(evidenceOf(3, {1, 1, 1})), "---");
  EXPECT_EQ(decided(evidenceOf(3, {-1, 1, -1})), "-m-");
  EXPECT_EQ(decided(evidenceOf(3, {-1, 0.05, 0})), "-m?");
  // One pair that errs against two that do not.
  EXPECT_EQ(decided(evidenceOf(4, {1, -0.3, 1, 1, 1, 1})), "----");
  // The root says nothing; most are right.
  EXPECT_EQ(decided(evidenceOf(6, {0, 0, 1, 0, -1, -1, 0, 1, 1, -1, 0, 1, 1, -1, 1})), "---m--");
  // Two and two: they differ, and which are right cannot be told.
  EXPECT_EQ(decided(evidenceOf(5, {0, 0, 1, 0, -1, -1, 0, -1, -1, 1})), "-!!!!");
}

TEST(Mirroring, ARootThatIsTheOddOneInACycleIsFound) {
  constexpr int count = 10;  // round a cycle, each with the two beside it
  Eigen::MatrixXd evidence = Eigen::MatrixXd::Zero(count, count);
  for (int i = 0; i < count; ++i) {
    const int j = (i + 1) % count;
    evidence(i, j) = evidence(j, i) = i == 0 || j == 0 ? -0.4 : 0.4;
  }
  EXPECT_EQ(decided(evidence), "-mmmmmmmmm");
  EXPECT_EQ(decided(evidence.cwiseAbs()), "----------");
}

TEST(Mirroring, ManyLayersAreDecidedAsFewAre) {
  for (const int count : {10, 40}) {  // all choices, and a search
    Eigen::MatrixXd evidence = Eigen::MatrixXd::Zero(count, count);
    std::string expected(static_cast<size_t>(count), '-');
    for (int i = 4; i < count - 2; i += 3) expected[static_cast<size_t>(i)] = 'm';
    for (int i = 1; i < count; ++i)
      for (int j = std::max(0, i - 2); j < i; ++j) {
        const bool alike = expected[static_cast<size_t>(i)] == expected[static_cast<size_t>(j)];
        evidence(i, j) = evidence(j, i) = (alike ? 0.6 : -0.6) + 0.1 * std::sin(7.0 * i + j);
      }
    EXPECT_EQ(decided(evidence), expected);
  }
}

}  // namespace
}  // namespace sphere_propagation
