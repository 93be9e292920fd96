// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/area/area_minimiser.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <new>

#include "tests/core/failing_allocation.h"
#include "tests/core/limb_meshes.h"
#include "tests/core/test_meshes.h"
#include "vcg_ext/area/area_schedule.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/root_map/harmonic_map.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation::test {
namespace {

AreaMinimiser minimiserOf(const ClosedSurface& surface) {
  return {surface, faceTargets(surface.vertices(), surface.faces())};
}

AreaStepParameters withWeights(double area, double shape) {
  AreaStepParameters parameters;
  parameters.weights = {area, shape};
  return parameters;
}

/// Takes steps and checks after each that the energy fell by the ratio returned, and that the map
/// is valid. Returns the share of the energy that is left.
double takeSteps(const ClosedSurface& surface, const AreaStepParameters& parameters, int steps,
                 Points& positions) {
  AreaMinimiser minimiser = minimiserOf(surface);
  const double start = minimiser.energy(parameters.weights, positions);
  double before = start;
  for (int i = 0; i < steps; ++i) {
    const double ratio = minimiser.step(parameters, positions);
    const double after = minimiser.energy(parameters.weights, positions);
    EXPECT_LE(after, before);
    EXPECT_NEAR(after / before, ratio, 1e-12);
    const Certificate certificate = certify(surface.faces(), positions);
    EXPECT_TRUE(certificate.valid()) << certificate.reason() << " after step " << i;
    before = after;
  }
  return before / start;
}

TEST(AreaMinimiser, NoStepRaisesTheEnergy) {
  for (const Mesh& mesh : {noisyEllipsoid(1), ellipsoid(10, 3, 1), cup(0.2, 24, 10)})
    for (const double shape : {0.3, 1e-4}) {
      const ClosedSurface surface(mesh.vertices, mesh.faces);
      Points positions = harmonicPositions(surface);
      EXPECT_LT(takeSteps(surface, withWeights(1, shape), 10, positions), 0.9);
    }
}

TEST(AreaMinimiser, StaysValidWhereFacesAreTinyOrWantToBe) {
  for (const double least : {1e-2, 1e-6, 2e-7}) {
    const Mesh mesh = rings(least);
    // The faces of the sphere are tiny, those of the surface are not.
    Mesh swollen = mesh;
    for (Eigen::Index v = 1; v < mesh.vertices.rows() - 1; ++v)
      swollen.vertices.row(v) *= 1 + 100 * (1 + mesh.vertices(v, 2));
    Points positions = mesh.vertices;
    takeSteps(ClosedSurface(swollen.vertices, swollen.faces), withWeights(1, 1e-3), 20, positions);
    // The other way round: the faces of the surface are tiny.
    const Mesh sphere = icosphereMesh(4);
    Mesh spiked = sphere;
    spiked.vertices.array() *= least;
    spiked.vertices.row(7) /= least;
    positions = sphere.vertices;
    takeSteps(ClosedSurface(spiked.vertices, spiked.faces), withWeights(1, 1e-6), 20, positions);
  }
}

TEST(AreaMinimiser, MovesOnFromFacesAsLargeAsAHemisphere) {
  const Mesh mesh = tetrahedron();
  Points positions(4, 3);
  positions << 0, 0, 1, 1, 0, -0.02, -0.5, std::sqrt(0.75), -0.02, -0.5, -std::sqrt(0.75), -0.02;
  positions.rowwise().normalize();
  ASSERT_TRUE(certify(mesh.faces, positions).valid());
  EXPECT_LT(takeSteps(ClosedSurface(mesh.vertices, mesh.faces), withWeights(1, 0.1), 10, positions),
            0.2);
}

TEST(AreaMinimiser, RestsAtTheOptimum) {
  for (const Mesh& mesh : {tetrahedron(), octahedron(), icosahedron()}) {
    const ClosedSurface surface(12 * mesh.vertices, mesh.faces);
    Points positions = mesh.vertices;
    EXPECT_NEAR(minimiserOf(surface).step(withWeights(1, 0.3), positions), 1, 1e-12);
    EXPECT_LT((positions - mesh.vertices).cwiseAbs().maxCoeff(), 1e-7);
  }
}

TEST(AreaMinimiser, ReturnsToTheOptimumNearby) {
  const Mesh mesh = icosphereMesh(5);
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  Random random(1);
  Points positions = mesh.vertices;
  for (Eigen::Index v = 0; v < positions.rows(); ++v)
    positions.row(v) += 0.03 * random.direction().transpose();
  positions.rowwise().normalize();
  ASSERT_TRUE(certify(mesh.faces, positions).valid());
  EXPECT_LT(takeSteps(surface, withWeights(1, 0), 20, positions), 1e-5);
}

TEST(AreaMinimiser, TakesNoStepFromPositionsThatAreNoMap) {
  const Mesh mesh = icosahedron();
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  AreaMinimiser minimiser = minimiserOf(surface);
  Points positions = mesh.vertices;
  positions.row(3) *= -1;
  const Points before = positions;
  EXPECT_EQ(minimiser.energy({1, 0.1}, positions), std::numeric_limits<double>::infinity());
  EXPECT_EQ(minimiser.step(withWeights(1, 0.1), positions), 1);
  EXPECT_EQ(positions, before);
}

TEST(AreaMinimiser, TakesNoStepFromAnEnergyOfZero) {
  const Mesh mesh = icosphereMesh(3);
  AreaMinimiser minimiser = minimiserOf(ClosedSurface(mesh.vertices, mesh.faces));
  Points positions = mesh.vertices;
  ASSERT_EQ(minimiser.energy({0, 0}, positions), 0);
  EXPECT_EQ(minimiser.step(withWeights(0, 0), positions), 1);
  EXPECT_EQ(positions, mesh.vertices);
}

TEST(AreaSchedule, EndsWithoutAShapeTerm) {
  // What AreaEnergyWeights say where nothing else is asked for: areas alone.
  const Mesh mesh = noisyEllipsoid(4);
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  AreaMinimiser minimiser = minimiserOf(surface);
  Points positions = harmonicPositions(surface);
  const double before = minimiser.energy({}, positions);
  const int steps = minimiseInStages(minimiser, {}, positions);
  EXPECT_GT(steps, 5);
  EXPECT_LT(steps, 400);
  EXPECT_LT(minimiser.energy({}, positions), 1e-3 * before);
  EXPECT_TRUE(certify(mesh.faces, positions).valid());
}

/// Every allocation fails once: what was thrown reaches the caller from whichever thread, and the
/// minimiser works on.
TEST(AreaMinimiser, OutOfMemoryIsAnException) {
  if (!FailingAllocation::possible()) GTEST_SKIP() << "the sanitizer has its own operator new";
  const Mesh mesh = blob(32, 0.3, 5);  // more faces than one thread takes
  ASSERT_GT(mesh.faces.rows(), ThreadPool::worthwhile);
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  const Points start = icosphere(32).vertices;
  ThreadPool pool(3);
  AreaMinimiser minimiser(surface, faceTargets(surface.vertices(), surface.faces()), &pool);
  Points expected = start;
  const double ratio = minimiser.step(withWeights(1, 1e-3), expected);
  AreaMinimiser fresh(surface, faceTargets(surface.vertices(), surface.faces()), &pool);
  int failures = 0;
  for (long n = 0;; n = n + 1 + n / 4) {
    Points positions = start;
    try {
      const FailingAllocation failing(n);
      EXPECT_EQ(fresh.step(withWeights(1, 1e-3), positions), ratio);
      EXPECT_EQ(positions, expected);
      if (!failing.failed()) break;
    } catch (const std::bad_alloc&) {
      EXPECT_EQ(positions, start);
      ++failures;
    }
  }
  EXPECT_GT(failures, 3);
}

TEST(AreaMinimiser, KeepsNothingFromOneCallToTheNext) {
  const Mesh mesh = noisyEllipsoid(2);
  const ClosedSurface surface(mesh.vertices, mesh.faces);
  const Points start = harmonicPositions(surface);
  AreaMinimiser minimiser = minimiserOf(surface);
  Points first = start, second = start;
  minimiser.step(withWeights(1, 0.1), first);
  minimiser.step(withWeights(1, 0.1), second);
  EXPECT_EQ(first, second);
}

}  // namespace
}  // namespace sphere_propagation::test
