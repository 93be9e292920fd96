// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/root_map/hierarchical_map.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "tests/core/limb_meshes.h"
#include "tests/core/sizes.h"
#include "vcg_ext/area/area_preserving_map.h"
#include "vcg_ext/area/local_step.h"
#include "vcg_ext/sphere/map_measures.h"

namespace sphere_propagation::test {
namespace {

Points mapOf(const Mesh& mesh, int threads = 1) {
  ThreadPool pool(threads);
  return hierarchicalMap(ClosedSurface(mesh.vertices, mesh.faces), energyWeights(0.9), pool)
      .positions;
}

TEST(HierarchicalMap, IsValidWhateverTheShape) {
  Mesh random = icosphereMesh(8);
  Random numbers(1);
  for (Eigen::Index v = 0; v < random.vertices.rows(); ++v)
    random.vertices.row(v) = numbers.direction().transpose();
  for (const Mesh& mesh : {tetrahedron(), bipyramid(3), bipyramid(sizeFor(5000, 500)),
                           limbs(sizeFor(20, 5), 1), tree(2, 3, 1), tree(3, 3, sizeFor(1, 0)),
                           disc(sizeFor(12, 8)), coil(3, 8, sizeFor(100, 40)), rings(1e-6),
                           ellipsoid(30, 20, 0), stretched(noisyEllipsoid(1), 100, 1, 1), random}) {
    ThreadPool pool;
    Mesh outward = mesh;
    for (int turn = 0; turn < 2; ++turn) {
      try {
        const ClosedSurface surface(outward.vertices, outward.faces);
        const HierarchicalResult result = hierarchicalMap(surface, energyWeights(0.9), pool);
        const Certificate certificate = certify(surface.faces(), result.positions);
        EXPECT_TRUE(certificate.valid())
            << mesh.vertices.rows() << " vertices: " << certificate.reason();
        break;
      } catch (const SurfaceError&) {  // random positions may be inside out
        outward.faces.col(1).swap(outward.faces.col(2));
      }
    }
  }
}

TEST(HierarchicalMap, IsTheSameWithAnyNumberOfThreads) {
  // Threads take part from a certain size on. Under sanitizers they run, and are not compared.
  const Mesh mesh = blob(underThreadSanitizer() ? 41 : sizeFor(50, 13), 0.3, 1);
  if (!underAddressSanitizer()) {
    ASSERT_GT(mesh.vertices.rows(), ThreadPool::worthwhile);
  }
  const Points several = mapOf(mesh, 3);
  ASSERT_TRUE(certify(mesh.faces, several).valid());
  if (underSanitizer()) return;
  for (const int threads : {1, 2}) EXPECT_EQ(mapOf(mesh, threads), several);
}

TEST(HierarchicalMap, DoesNotDependOnTheNumbering) {
  const Mesh mesh = noisyEllipsoid(8);
  const Points reference = mapOf(mesh);
  Random random(1);
  const auto shuffled = [&](Eigen::Index count) {
    std::vector<int> order(static_cast<size_t>(count));
    std::iota(order.begin(), order.end(), 0);
    for (size_t i = order.size(); i > 1; --i)
      std::swap(order[i - 1], order[random.index(static_cast<int>(i))]);
    return order;
  };
  const std::vector<int> vertexOrder = shuffled(mesh.vertices.rows()),
                         faceOrder = shuffled(mesh.faces.rows());
  Mesh renumbered = mesh;
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
    renumbered.vertices.row(vertexOrder[v]) = mesh.vertices.row(v);
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      renumbered.faces(faceOrder[f], (k + static_cast<int>(f)) % 3) = vertexOrder[mesh.faces(f, k)];
  const Points result = mapOf(renumbered);
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
    EXPECT_LT((result.row(vertexOrder[v]) - reference.row(v)).norm(), 1e-9);
}

TEST(HierarchicalMap, StandsAsTheSurfaceDoes) {
  const Mesh mesh = noisyEllipsoid(5);
  const Points reference = mapOf(mesh);
  for (const double scale : {1e-30, 0.01, 1e30})
    EXPECT_LT((mapOf({scale * mesh.vertices, mesh.faces}) - reference).cwiseAbs().maxCoeff(), 1e-5);
  const double sd = measureMap(ClosedSurface(mesh.vertices, mesh.faces), reference).areaRatioSd;
  // Another hierarchy, the same optimum but for how near it came.
  for (unsigned seed = 0; seed < static_cast<unsigned>(sizeFor(4, 1)); ++seed) {
    const Eigen::Matrix3d rotation = randomRotation(seed);
    const Mesh turned = transformed(mesh, rotation, 1, Vector3(30, -10, 5));
    const Points map = mapOf(turned);
    EXPECT_LT((map - reference * rotation.transpose()).rowwise().norm().mean(), 0.03);
    EXPECT_NEAR(measureMap(ClosedSurface(turned.vertices, turned.faces), map).areaRatioSd / sd, 1,
                0.3);
  }
}

TEST(LocalStep, LowersTheEnergyAndStaysInside) {
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    VertexStar star;
    const int sides = 3 + random.index(6);
    for (int j = 0; j < sides; ++j) {
      const double angle = 2 * pi * (j + random.uniform(0, 0.5)) / sides,
                   radius = random.uniform(0.3, 0.6);
      star.rim.push_back(
          Vector3(radius * std::cos(angle), radius * std::sin(angle), 1).normalized());
      star.targets.emplace_back(random.uniform(0.01, 0.2), random.uniform(0.5, 5),
                                std::array<float, 3>{0.5F, 0.5F, 0.5F});
    }
    const AreaEnergyWeights weights{1, 0.05};
    const auto energy = [&](const Vector3& x) {
      double sum = 0;
      for (int j = 0; j < sides; ++j) {
        const std::array<Vector3, 3> p{x, star.rim[j], star.rim[(j + 1) % sides]};
        sum += faceEnergy(star.targets[j], weights, solidAngle(p[0], p[1], p[2]), p);
      }
      return sum;
    };
    Vector3 x = Vector3::UnitZ();
    if (!std::isfinite(energy(x))) continue;
    const double before = energy(x);
    EXPECT_GT(relaxVertex(star, weights, 50, x), 0);
    EXPECT_NEAR(x.norm(), 1, 1e-14);
    const double after = energy(x);
    EXPECT_LT(after, before);
    for (int j = 0; j < 8; ++j)  // a minimum
      EXPECT_GT(energy((x + 1e-3 * random.direction()).normalized()), after - 1e-5);
  }
}

}  // namespace
}  // namespace sphere_propagation::test
