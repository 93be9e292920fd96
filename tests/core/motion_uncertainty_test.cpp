// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_uncertainty.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "tests/core/sizes.h"
#include "tests/core/test_meshes.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/propagation/propagation.h"
#include "vcg_ext/sequence/propagation_order.h"

namespace sphere_propagation {
namespace {

Eigen::MatrixXd positive(Eigen::Index size, double least) {
  const Eigen::MatrixXd root = Eigen::MatrixXd::Random(size, size);
  Eigen::MatrixXd matrix = root * root.transpose();
  matrix.diagonal().array() += least;
  return matrix;
}

/// Surfaces that beat, each on a mesh of its own.
std::vector<ClosedSurface> beating(int count, double scale = 1) {
  std::vector<ClosedSurface> surfaces;
  for (int i = 0; i < count; ++i) {
    test::Mesh mesh = test::transformed(test::icosphereMesh(test::sizeFor(8, 5) + i % 2),
                                        test::randomRotation(30 + i), 1, Vector3::Zero());
    const double along = 1 - 0.2 * (1 - std::cos(2 * 3.14159265 * i / count)) / 2;
    mesh.vertices.col(2) *= 1.6 * along;
    mesh.vertices.leftCols<2>() *= 2 - along;
    mesh.vertices *= 20 * scale;
    surfaces.emplace_back(mesh.vertices, mesh.faces, "phase " + std::to_string(i));
  }
  return surfaces;
}

Propagation followed(const std::vector<ClosedSurface>& surfaces, const PropagationTree& tree,
                     bool uncertainty, int threads = 1, bool closes = false) {
  const Points first = surfaces[0].vertices();
  Points sphere = first;
  sphere.col(2) /= 1.6;
  const MappedSurface root(surfaces[0], sphere.rowwise().normalized());
  PropagationParameters parameters;
  parameters.threads = threads;
  parameters.motion.uncertainty = uncertainty;
  if (closes) parameters.closing = closingArc(static_cast<int>(surfaces.size()), 0);
  return propagate(Sequence(surfaces), root, tree, parameters);
}

}  // namespace

TEST(BoundChain, ItsCovariancesAreThoseOfTheWholeMatrix) {
  constexpr Eigen::Index layers = 5, size = 3, shared = 2;
  std::srand(3);
  BoundChain chain{{}, 1e-3 * Eigen::MatrixXd::Identity(layers, layers), {}, {}};
  // Two chains, not in the order of their numbers: 3 - 0 - 4 and 2 - 1.
  const auto bind = [&](Eigen::Index s, Eigen::Index t, double precision) {
    chain.inTime(s, s) += precision;
    chain.inTime(t, t) += precision;
    chain.inTime(s, t) -= precision;
    chain.inTime(t, s) -= precision;
  };
  bind(3, 0, 1.5);
  bind(0, 4, 0.7);
  bind(2, 1, 2);
  const Eigen::Index all = layers * size + shared;
  Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(all, all);
  for (Eigen::Index s = 0; s < layers; ++s) {
    chain.blocks.push_back(positive(size, 1));
    chain.coupling.emplace_back(0.3 * Eigen::MatrixXd::Random(size, shared));
    for (Eigen::Index t = 0; t < layers; ++t)
      whole.block(s * size, t * size, size, size).diagonal().setConstant(chain.inTime(s, t));
    whole.block(s * size, s * size, size, size) += chain.blocks.back();
    whole.block(s * size, layers * size, size, shared) = chain.coupling.back();
    whole.block(layers * size, s * size, shared, size) = chain.coupling.back().transpose();
  }
  chain.shared = positive(shared, 2);
  whole.bottomRightCorner(shared, shared) = chain.shared;
  const Eigen::MatrixXd inverse = whole.inverse();
  ThreadPool pool(2);
  const std::vector<Eigen::MatrixXd> found = covariancesOf(chain, pool);
  for (Eigen::Index s = 0; s < layers; ++s)
    EXPECT_LT((found[static_cast<size_t>(s)] - inverse.block(s * size, s * size, size, size))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-9)
        << s;
}

TEST(MotionUncertainty, IsThatOfMotionAlongTheSurface) {
  const std::vector<ClosedSurface> surfaces = beating(1);
  Points sphere = surfaces[0].vertices();
  sphere.col(2) /= 1.6;
  const MotionModel model(MappedSurface(surfaces[0], sphere.rowwise().normalized()));
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(MotionBasis::columns);
  const Points normals = vertexNormals(model.nodes(), model.faces());
  // A translation along z of standard deviation 1: sin of the normal's angle to z, over both axes.
  const Eigen::VectorXd forces = model.basis().projectAll(
      Points::Constant(model.nodes().rows(), 3, 0).rowwise() + Eigen::RowVector3d(0, 0, 1));
  Eigen::VectorXd shift = rest;
  shift.segment(MotionBasis::localColumns, 3) = forces.segment(MotionBasis::localColumns, 3);
  const double moved = model.basis().displacements(shift).row(0).norm();
  ASSERT_GT(moved, 0);
  const double unit = std::sqrt(0.5 * model.meanVertexArea());
  const Eigen::MatrixXd covariance = shift * shift.transpose() / (moved * moved * unit * unit);
  const Eigen::VectorXd known = deviationsAlongSurface(model, rest, covariance);
  for (Eigen::Index i = 0; i < known.size(); ++i)
    EXPECT_NEAR(known[i], std::sqrt(0.5 * (1 - normals(i, 2) * normals(i, 2))), 1e-4) << i;
}

TEST(MotionUncertainty, GrowsAlongTheTreeAndWithTheUnitAndChangesNoMap) {
  constexpr int layers = 5;
  const PropagationTree tree = timeOrder(layers, 0);
  const Propagation plain = followed(beating(layers), tree, false),
                    asked = followed(beating(layers), tree, true, 2),
                    larger = followed(beating(layers, 10), tree, true);
  double before = 0;
  for (size_t t = 0; t < layers; ++t) {
    EXPECT_EQ(plain.layers[t].uncertainty.size(), 0);
    EXPECT_EQ(plain.layers[t].map().positions(), asked.layers[t].map().positions()) << t;
    const Eigen::VectorXd& known = asked.layers[t].uncertainty;
    ASSERT_EQ(known.size(), asked.layers[t].map().vertexCount()) << t;
    if (t == 0) {
      EXPECT_EQ(known.norm(), 0);
      continue;
    }
    EXPECT_GT(known.minCoeff(), 0);
    if (t < 4) {  // the fifth is on its way back
      EXPECT_GT(known.mean(), before) << t;
    }
    before = known.mean();
    EXPECT_NEAR(larger.layers[t].uncertainty.mean(), 10 * before, 0.02 * before) << t;
  }
}

TEST(MotionUncertainty, OfACycleIsLargestFarFromTheRoot) {
  if (test::underThreadSanitizer()) GTEST_SKIP() << "starts no thread";
  const int layers = test::sizeFor(8, 6);
  const auto last = static_cast<size_t>(layers - 1), far = static_cast<size_t>(layers / 2);
  const PropagationTree tree = cyclicTimeOrder(layers, 0);
  const Propagation one = followed(beating(layers), tree, true),
                    both = followed(beating(layers), tree, true, 1, true);
  ASSERT_GT(both.averaged, 0);
  // Where both ways are equally long, two say more than one.
  EXPECT_LT(both.layers[far].uncertainty.mean(), one.layers[far].uncertainty.mean());
  EXPECT_LT(both.layers[1].uncertainty.mean(), both.layers[far].uncertainty.mean());
  EXPECT_LT(both.layers[last].uncertainty.mean(), both.layers[far].uncertainty.mean());
}

TEST(MotionUncertainty, OfAllLayersAtOnceIsTheSameForAnyNumberOfThreads) {
  constexpr int layers = 12;
  const PropagationTree tree = cyclicTimeOrder(layers, 0);
  const Propagation three = followed(beating(layers), tree, true, 3, true);
  ASSERT_EQ(three.smoothed, layers - 1);
  EXPECT_EQ(three.rootError.size(), three.layers[0].map().vertexCount());
  for (size_t t = 1; t < layers; ++t) EXPECT_GT(three.layers[t].uncertainty.minCoeff(), 0) << t;
  EXPECT_LT(three.layers[1].uncertainty.mean(), three.layers[6].uncertainty.mean());
  if (test::underSanitizer()) return;  // a second run meets what the first did
  const Propagation one = followed(beating(layers), tree, true, 1, true);
  for (size_t t = 1; t < layers; ++t)
    EXPECT_EQ(one.layers[t].uncertainty, three.layers[t].uncertainty) << t;
}

}  // namespace sphere_propagation
