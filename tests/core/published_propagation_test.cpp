// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/published/published_propagation.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <numeric>
#include <set>
#include <string>

#include "tests/core/test_meshes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/propagation/transfer/residual.h"
#include "vcg_ext/registration/principal_axes.h"
#include "vcg_ext/registration/rigid_alignment.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation {
namespace {

using test::Mesh;

/// All nodes at these positions, fixed where listed.
FixedNodes fixedAt(const Points& positions, const std::vector<int>& fixed) {
  std::vector<VertexPair> pairs;
  for (int v : fixed) pairs.push_back({v, v});
  return fixNodes(static_cast<int>(positions.rows()), pairs, positions);
}

std::vector<int> fixedOf(const FixedNodes& nodes) {
  std::vector<int> fixed;
  for (int v = 0; v < static_cast<int>(nodes.isFixed.size()); ++v)
    if (nodes.isFixed[v]) fixed.push_back(v);
  return fixed;
}

Points unitRows(Points points) {
  points.rowwise().normalize();
  return points;
}

Points randomPositions(int count, unsigned seed) {
  test::Random random(seed);
  Points positions(count, 3);
  for (int v = 0; v < count; ++v) positions.row(v) = random.direction().transpose();
  return positions;
}

/// An irregular surface and a valid map of it: the icosphere that it was made from.
struct Example {
  Mesh mesh = test::noisyEllipsoid(1);
  ClosedSurface surface = surfaceOf(mesh, "reference");
  MappedSurface map{surface, test::icosphereMesh(8).vertices};
};

double largestDifference(const Points& a, const Points& b) { return (a - b).cwiseAbs().maxCoeff(); }

// Step 4d.

TEST(FixNodes, TakeThePositionOfTheirPartner) {
  const Points reference = test::octahedron().vertices;
  const FixedNodes nodes = fixNodes(4, {{1, 5}, {3, 0}}, reference);
  EXPECT_EQ(nodes.count(), 2);
  EXPECT_EQ(fixedOf(nodes), (std::vector<int>{1, 3}));
  EXPECT_EQ(nodes.positions.row(1), reference.row(5));
  EXPECT_EQ(nodes.positions.row(3), reference.row(0));
}

TEST(ReleaseInwardTriangles, KeepsWhatPointsOutwards) {
  const Mesh mesh = test::icosahedron();
  std::vector<int> all(12);
  std::iota(all.begin(), all.end(), 0);
  const FixedNodes nodes = fixedAt(mesh.vertices, all);
  EXPECT_EQ(releaseInwardTriangles(mesh.faces, nodes).count(), 12);
}

TEST(ReleaseInwardTriangles, AnInwardTriangleLosesItsThreeNodes) {
  const Mesh mesh = test::icosahedron();
  Points positions = mesh.vertices;
  positions.row(0).swap(positions.row(11));  // reverses face (0, 11, 5)
  const FixedNodes kept =
      releaseInwardTriangles(mesh.faces, fixedAt(positions, {0, 5, 11, 3, 6, 8}));
  EXPECT_EQ(fixedOf(kept), (std::vector<int>{3, 6, 8}));  // face (3, 6, 8) points outwards
  EXPECT_EQ(kept.positions.row(6), positions.row(6));
}

TEST(ReleaseInwardTriangles, JudgesOnlyTrianglesWithThreeFixedNodes) {
  const Mesh mesh = test::icosahedron();
  Points positions = mesh.vertices;
  positions.row(0).swap(positions.row(11));
  EXPECT_EQ(releaseInwardTriangles(mesh.faces, fixedAt(positions, {0, 11, 3})).count(), 3);
}

TEST(ReleaseInwardTriangles, GoesOverTheOriginalNodesOnce) {
  // A mirrored octahedron: of the four fixed nodes two adjacent faces, (0, 2, 4) and (2, 1, 4),
  // point inwards. The second must be judged although the first has lost its nodes.
  const Mesh mesh = test::octahedron();
  Points mirrored = mesh.vertices;
  mirrored.col(0) *= -1;
  EXPECT_EQ(releaseInwardTriangles(mesh.faces, fixedAt(mirrored, {0, 1, 2, 4})).count(), 0);
}

// Step 4e.

TEST(PlaceMovingNodes, OneMovingNodeIsTheMeanOfItsNeighbours) {
  const Mesh mesh = test::octahedron();
  const Points positions = randomPositions(6, 3);
  const Points placed = placeMovingNodes(surfaceOf(mesh), fixedAt(positions, {0, 1, 2, 3, 5}));
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  for (int w : {0, 1, 2, 3}) sum += positions.row(w);
  EXPECT_LT((placed.row(4) - sum.normalized()).norm(), 1e-14);
  for (int v : {0, 1, 2, 3, 5}) EXPECT_EQ(placed.row(v), positions.row(v));
}

TEST(PlaceMovingNodes, TwoMovingNodesSolveTheirSystem) {
  // Nodes 0 and 4 move and are neighbours:  4 x0 - x4 = p2 + p3 + p5,  4 x4 - x0 = p1 + p2 + p3.
  const Mesh mesh = test::octahedron();
  const Points p = randomPositions(6, 4);
  const Points placed = placeMovingNodes(surfaceOf(mesh), fixedAt(p, {1, 2, 3, 5}));
  const Eigen::RowVector3d b0 = p.row(2) + p.row(3) + p.row(5), b4 = p.row(1) + p.row(2) + p.row(3);
  EXPECT_LT((placed.row(0) - ((4 * b0 + b4) / 15).normalized()).norm(), 1e-14);
  EXPECT_LT((placed.row(4) - ((4 * b4 + b0) / 15).normalized()).norm(), 1e-14);
}

TEST(PlaceMovingNodes, ManyMovingNodesSolveTheDenseSystem) {
  const Mesh mesh = test::icosphereMesh(4);
  const int n = static_cast<int>(mesh.vertices.rows());
  std::vector<int> fixed;
  for (int v = 0; v < n; v += 5) fixed.push_back(v);
  const FixedNodes nodes = fixedAt(randomPositions(n, 5), fixed);
  // The paper's equations over all nodes, with a row of the identity for each fixed one.
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  for (int f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      A(mesh.faces(f, k), mesh.faces(f, (k + 1) % 3)) = -1;  // its twin does the other way
  for (int v = 0; v < n; ++v) A(v, v) = -A.row(v).sum();
  Eigen::MatrixX3d b = Eigen::MatrixX3d::Zero(n, 3);
  for (int v : fixed) {
    A.row(v).setZero();
    A(v, v) = 1;
    b.row(v) = nodes.positions.row(v);
  }
  const Points expected = unitRows(A.partialPivLu().solve(b));
  EXPECT_LT(largestDifference(placeMovingNodes(surfaceOf(mesh), nodes), expected), 1e-11);
}

TEST(PlaceMovingNodes, ANodeAtTheCentreTakesTheFirstFixedPosition) {
  const Mesh mesh = test::octahedron();  // the neighbours of node 4 cancel
  const Points placed = placeMovingNodes(surfaceOf(mesh), fixedAt(mesh.vertices, {0, 1, 2, 3, 5}));
  EXPECT_EQ(placed.row(4), mesh.vertices.row(0));
}

TEST(PlaceMovingNodes, NeedsAFixedNode) {
  const Mesh mesh = test::octahedron();
  try {
    placeMovingNodes(surfaceOf(mesh, "phase 3"), fixedAt(mesh.vertices, {}));
    FAIL() << "no error";
  } catch (const PropagationError& error) {
    EXPECT_NE(std::string(error.what()).find("phase 3"), std::string::npos);
  }
}

// Step 4f.

TEST(SmoothOnSphere, OneSweepByHand) {
  Mesh mesh;  // edges 0-1, 0-2, 0-3 of length 1, 2, 4
  mesh.vertices.resize(4, 3);
  mesh.vertices << 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 4;
  mesh.faces.resize(4, 3);
  mesh.faces << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
  const Points p = randomPositions(4, 6);
  const Points smoothed = smoothOnSphere(surfaceOf(mesh), p, 1);
  Points expected(4, 3);
  expected.row(0) = p.row(1) + p.row(2) / 2 + p.row(3) / 4;
  expected.row(1) = p.row(0) + p.row(2) / std::sqrt(5.0) + p.row(3) / std::sqrt(17.0);
  expected.row(2) = p.row(0) / 2 + p.row(1) / std::sqrt(5.0) + p.row(3) / std::sqrt(20.0);
  expected.row(3) = p.row(0) / 4 + p.row(1) / std::sqrt(17.0) + p.row(2) / std::sqrt(20.0);
  EXPECT_LT(largestDifference(smoothed, unitRows(expected)), 1e-14);
}

TEST(SmoothOnSphere, SweepsFollowOneAnother) {
  const Example e;
  EXPECT_EQ(smoothOnSphere(e.surface, e.map.positions(), 0), e.map.positions());
  const Points one = smoothOnSphere(e.surface, e.map.positions(), 1);
  EXPECT_GT(largestDifference(one, e.map.positions()), 1e-3);
  EXPECT_EQ(smoothOnSphere(e.surface, smoothOnSphere(e.surface, one, 1), 1),
            smoothOnSphere(e.surface, one, 2));
  EXPECT_EQ(smoothOnSphere(e.surface, e.map.positions(), 3), smoothOnSphere(e.surface, one, 2));
}

TEST(SmoothOnSphere, DoesNotDependOnTheOrderOfTheVertices) {
  const Example e;
  const int n = e.surface.vertexCount();
  std::vector<int> place(static_cast<size_t>(n));  // where vertex v is in the other mesh
  std::iota(place.begin(), place.end(), 0);
  test::Random random(8);
  for (int v = n - 1; v > 0; --v) std::swap(place[v], place[random.index(v + 1)]);
  Mesh other = e.mesh;
  Points positions(n, 3);
  for (int v = 0; v < n; ++v) {
    other.vertices.row(place[v]) = e.mesh.vertices.row(v);
    positions.row(place[v]) = e.map.positions().row(v);
  }
  for (int f = 0; f < other.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) other.faces(f, k) = place[e.mesh.faces(f, k)];
  const Points here = smoothOnSphere(e.surface, e.map.positions(), 50);
  const Points there = smoothOnSphere(surfaceOf(other), positions, 50);
  for (int v = 0; v < n; ++v) EXPECT_LT((there.row(place[v]) - here.row(v)).norm(), 1e-12);
}

TEST(SmoothOnSphere, TurnsWithThePositionsAndIgnoresScale) {
  const Example e;
  const Points smoothed = smoothOnSphere(e.surface, e.map.positions(), 10);
  const Eigen::Matrix3d rotation = test::randomRotation(9);
  const Points turned = smoothOnSphere(e.surface, e.map.positions() * rotation.transpose(), 10);
  EXPECT_LT(largestDifference(turned, smoothed * rotation.transpose()), 1e-13);
  for (double scale : {1e-3, 1e6}) {
    const Mesh moved = test::transformed(e.mesh, rotation, scale, Vector3(1, 2, 3));
    EXPECT_LT(largestDifference(smoothOnSphere(surfaceOf(moved), e.map.positions(), 10), smoothed),
              1e-11);
  }
}

TEST(SmoothOnSphere, ANodeWhoseNeighboursCancelStays) {
  const Mesh mesh = test::octahedron();
  EXPECT_EQ(smoothOnSphere(surfaceOf(mesh), mesh.vertices, 5), mesh.vertices);
}

TEST(SmoothOnSphere, AnEdgeWithoutLengthStaysANumber) {
  Mesh mesh = test::icosahedron();
  const Points positions = mesh.vertices;
  mesh.vertices.row(0) = mesh.vertices.row(1);  // neighbours at one place
  const Points smoothed = smoothOnSphere(surfaceOf(mesh), positions, 1);
  ASSERT_TRUE(smoothed.allFinite());
  // Weight 1e12 against 1: each goes where the other was.
  EXPECT_LT((smoothed.row(0) - positions.row(1)).norm(), 1e-10);
  EXPECT_LT((smoothed.row(1) - positions.row(0)).norm(), 1e-10);
}

TEST(SmoothOnSphere, RefusesANegativeNumberOfSweeps) {
  const Mesh mesh = test::octahedron();
  EXPECT_THROW(smoothOnSphere(surfaceOf(mesh), mesh.vertices, -1), ParameterError);
}

// The whole arc.

TEST(PublishedPropagation, ToTheSameSurfaceWithoutSweepsIsTheIdentity) {
  const Example e;
  const TransferredMap result = propagateAsPublished(e.map, e.surface, {true, 30, 0});
  EXPECT_LT(largestDifference(result.map.positions(), e.map.positions()), 1e-15);
  EXPECT_EQ(findCorrespondence(e.map, e.surface).nodes.count(), e.surface.vertexCount());
  EXPECT_EQ(result.repairedFaces, 0);
  EXPECT_LT(result.residual.mean, 1e-10);
  EXPECT_LT(result.residual.p95, 1e-10);
}

TEST(PublishedPropagation, DefaultsAreThePapers) {
  const PublishedParameters defaults;
  EXPECT_TRUE(defaults.anisotropicScaling);
  EXPECT_EQ(defaults.icpIterations, 30);
  EXPECT_EQ(defaults.smoothingSweeps, 50);
}

TEST(PublishedPropagation, IsItsStepsOneAfterTheOther) {
  const Example e;
  const Mesh other =
      test::transformed(test::ellipsoid(34, 19, 13, 7), test::randomRotation(1001) /* e's own */, 1,
                        Vector3(20, 0, 5));
  const ClosedSurface target = surfaceOf(other, "target");
  bool repaired = false;
  for (int sweeps : {0, 1, 50}) {
    const VertexLocator reference(e.mesh.vertices);
    const Points scaled = scaledToExtents(other.vertices, principalAxes(e.mesh.vertices));
    const Points aligned = alignRigidly(scaled, reference, 30).motion.applyTo(scaled);
    const std::vector<VertexPair> pairs = mutualNearest(VertexLocator(aligned), reference);
    const FixedNodes nodes = releaseInwardTriangles(
        other.faces, fixNodes(target.vertexCount(), pairs, e.map.positions()));
    EXPECT_GT(nodes.count(), 100);
    EXPECT_LT(nodes.count(), target.vertexCount() - 10);  // so that there are moving nodes
    const Points positions = smoothOnSphere(target, placeMovingNodes(target, nodes), sweeps);
    const long flipped = certify(target.faces(), positions).flippedFaces;
    repaired = repaired || flipped > 0;

    const TransferredMap result = propagateAsPublished(e.map, target, {true, 30, sweeps});
    EXPECT_EQ(findCorrespondence(e.map, target).nodes.count(), nodes.count());
    EXPECT_EQ(result.repairedFaces, flipped);
    if (flipped == 0) {
      EXPECT_LT(largestDifference(result.map.positions(), positions), 1e-15);
    }
    EXPECT_TRUE(certify(target.faces(), result.map.positions()).valid());
    EXPECT_GT(result.residual.mean, 0.1);  // the reference's noise
    EXPECT_GT(result.residual.p95, result.residual.mean);
    EXPECT_LT(result.residual.p95, 3);
  }
  EXPECT_TRUE(repaired) << "no case had anything to repair: this test no longer tests the count";
}

TEST(PublishedPropagation, ScalingUndoesADilationAlongThePrincipalAxes) {
  const Example e;
  const PrincipalAxes axes = principalAxes(e.mesh.vertices);
  Mesh dilated = e.mesh;
  dilated.vertices *= axes.axes * Vector3(1.3, 0.9, 0.7).asDiagonal() * axes.axes.transpose();
  const ClosedSurface target = surfaceOf(dilated);
  const TransferredMap with = propagateAsPublished(e.map, target, {true, 30, 0});
  EXPECT_LT(largestDifference(with.map.positions(), e.map.positions()), 1e-15);
  EXPECT_LT(with.residual.mean, 1e-9);
  const TransferredMap without = propagateAsPublished(e.map, target, {false, 30, 0});
  EXPECT_LT(findCorrespondence(e.map, target, {false, 30, 0}).nodes.count(), target.vertexCount());
  EXPECT_GT(without.residual.mean, 1);
}

TEST(PublishedPropagation, DoesNotDependOnWhereTheSurfacesAre) {
  const Example e;
  const Mesh other = test::transformed(
      test::noisyEllipsoid(2), test::randomRotation(1001) * test::randomRotation(1002).transpose(),
      1, Vector3(3, 2, 1));  // turned as e is
  const TransferredMap here = propagateAsPublished(e.map, surfaceOf(other));
  const Eigen::Matrix3d rotation = test::randomRotation(12);
  for (double scale : {0.01, 1.0, 1000.0}) {
    const ClosedSurface reference =
        surfaceOf(test::transformed(e.mesh, rotation, scale, Vector3(-50, 8, 9)));
    const ClosedSurface target =
        surfaceOf(test::transformed(other, rotation, scale, Vector3(-5, 80, 7)));
    const TransferredMap there =
        propagateAsPublished(MappedSurface(reference, e.map.positions()), target);
    EXPECT_EQ(findCorrespondence(MappedSurface(reference, e.map.positions()), target).nodes.count(),
              findCorrespondence(e.map, surfaceOf(other)).nodes.count());
    EXPECT_LT(largestDifference(there.map.positions(), here.map.positions()), 1e-9);
    EXPECT_NEAR(there.residual.mean, scale * here.residual.mean, 1e-6 * scale);
    EXPECT_NEAR(there.residual.p95, scale * here.residual.p95, 1e-6 * scale);
  }
}

TEST(PublishedPropagation, TurnsWithTheReferencesMap) {
  const Example e;
  const ClosedSurface target = surfaceOf(test::transformed(
      test::noisyEllipsoid(2), test::randomRotation(1001) * test::randomRotation(1002).transpose(),
      1, Vector3::Zero()));
  const Eigen::Matrix3d rotation = test::randomRotation(13);
  const MappedSurface turned(e.surface, e.map.positions() * rotation.transpose());
  const TransferredMap a = propagateAsPublished(e.map, target);
  const TransferredMap b = propagateAsPublished(turned, target);
  EXPECT_LT(largestDifference(b.map.positions(), a.map.positions() * rotation.transpose()), 1e-9);
}

TEST(PublishedPropagation, ResidualIsTheDistanceFromTheReferenceSurface) {
  const ClosedSurface reference = surfaceOf(test::ellipsoid(10, 10, 10, 4)),
                      target = surfaceOf(test::ellipsoid(11, 11, 11, 4));
  const MappedSurface map(reference, test::icosphereMesh(4).vertices);
  const TransferredMap result = propagateAsPublished(map, target, {false, 30, 0});
  EXPECT_NEAR(result.residual.mean, 1, 1e-12);
  EXPECT_NEAR(result.residual.p95, 1, 1e-12);
}

TEST(PublishedPropagation, RefusesWhatIsOutOfRange) {
  const Example e;
  EXPECT_THROW(propagateAsPublished(e.map, e.surface, {true, -1, 50}), ParameterError);
  EXPECT_THROW(propagateAsPublished(e.map, e.surface, {true, 30, -1}), ParameterError);
}

TEST(PublishedPropagation, NamesTheTwoSurfacesThatCorrespondNowhere) {
  // A flat double cover, and the same with its faces reversed: the vertices agree, and every
  // triangle points inwards.
  Mesh flat = test::tetrahedron(), reversed;
  flat.vertices << 3, 1, 0, -3, 2, 0, -2, -1, 0, 2, -2, 0;
  reversed = flat;
  reversed.faces.col(1).swap(reversed.faces.col(2));
  const ClosedSurface reference = surfaceOf(flat, "first phase"),
                      target = surfaceOf(reversed, "second phase");
  const MappedSurface map(reference, test::tetrahedron().vertices);
  try {
    propagateAsPublished(map, target);
    FAIL() << "no error";
  } catch (const PropagationError& error) {
    EXPECT_NE(std::string(error.what()).find("first phase"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("second phase"), std::string::npos);
  }
}

TEST(Residual, IsTheMeanAndTheInterpolatedPercentile) {
  EXPECT_EQ(residualOf({}).mean, 0);
  EXPECT_EQ(residualOf({3}).p95, 3);
  std::vector<double> distances(21);
  for (int i = 0; i < 21; ++i) distances[i] = (i * 8) % 21;  // 0 .. 20 in another order
  EXPECT_DOUBLE_EQ(residualOf(distances).mean, 10);
  EXPECT_DOUBLE_EQ(residualOf(distances).p95, 19);
  EXPECT_DOUBLE_EQ(residualOf({0, 10}).p95, 9.5);
}

}  // namespace
}  // namespace sphere_propagation
