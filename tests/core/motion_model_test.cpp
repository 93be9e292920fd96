// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_model.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "tests/core/test_meshes.h"

namespace sphere_propagation {
namespace {

struct Ellipsoid {
  ClosedSurface surface;
  MappedSurface map;
  Ellipsoid() : Ellipsoid(test::icosphereMesh(9)) {}

 private:
  explicit Ellipsoid(const test::Mesh& sphere)
      : surface(sphere.vertices * Vector3(40, 25, 20).asDiagonal(), sphere.faces, "ellipsoid"),
        map(surface, sphere.vertices) {}
};

Eigen::VectorXd unitCoefficient(int column) {
  return Eigen::VectorXd::Unit(MotionBasis::columns, column);
}

Eigen::VectorXd someCoefficients(unsigned seed) {
  test::Random random(seed);
  Eigen::VectorXd c(MotionBasis::columns);
  for (double& x : c) x = random.uniform(-1, 1);
  return c;
}

TEST(MotionModel, ZeroCoefficientsMoveNothing) {
  const Ellipsoid e;
  const MotionModel model(e.map);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(MotionBasis::columns);
  EXPECT_EQ(model.movedNodes(zero), model.nodes());
  EXPECT_EQ(model.movedVertices(zero), e.surface.vertices());
  EXPECT_EQ(model.nodes().rows(), 1002);
}

TEST(MotionModel, ProjectionIsTheTransposedDisplacement) {
  const Ellipsoid e;
  const MotionModel model(e.map);
  const Eigen::VectorXd c = someCoefficients(1);
  const Points moved = model.movedNodes(c) - model.nodes();
  Eigen::VectorXd row(MotionBasis::columns);
  for (int i : {0, 17, 500, 1001}) {
    const Vector3 m = Vector3(1, -2, 0.5).normalized();
    model.basis().project(i, m, row.data());
    EXPECT_NEAR(row.dot(c), m.dot(moved.row(i).transpose()), 1e-12);
  }
}

TEST(MotionModel, ProjectsAllForcesAtOnce) {
  const Ellipsoid e;
  const MotionModel model(e.map);
  Points forces(model.nodes().rows(), 3);
  test::Random random(2);
  for (Eigen::Index i = 0; i < forces.size(); ++i) forces.data()[i] = random.normal();
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(MotionBasis::columns), row(MotionBasis::columns);
  for (Eigen::Index i = 0; i < forces.rows(); ++i) {
    model.basis().project(static_cast<int>(i), forces.row(i).transpose(), row.data());
    sum += row;
  }
  EXPECT_LT((model.basis().projectAll(forces) - sum).norm(), 1e-11 * sum.norm());
}

TEST(MotionModel, SinglePrecisionIsCloseEnough) {
  const Ellipsoid e;
  const MotionModel model(e.map);
  const Eigen::VectorXd c = someCoefficients(1);
  const Points moved = model.movedNodes(c) - model.nodes();
  const Points nearly = model.roughMovedNodes(c) - model.nodes();
  EXPECT_LT((moved - nearly).norm(), 1e-6 * moved.norm());
  const Eigen::VectorXd sum = model.basis().projectAll(moved);
  EXPECT_LT((sum - model.basis().roughProjectAll(moved)).norm(), 1e-6 * sum.norm());
  const Eigen::VectorXd weights = Eigen::VectorXd::LinSpaced(moved.rows(), 0, 1);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(MotionBasis::columns, MotionBasis::columns);
  Eigen::VectorXd row(MotionBasis::columns);
  for (int i = 0; i < moved.rows(); ++i) {
    model.basis().project(i, moved.row(i).transpose(), row.data());
    information += weights[i] * row * row.transpose();
  }
  EXPECT_LT((model.basis().roughInformation(moved, weights) - information).norm(),
            1e-6 * information.norm());
}

TEST(MotionModel, AffineColumnsTranslateStrainAndRotate) {
  const Ellipsoid e;
  const MotionModel model(e.map);
  const Eigen::VectorXd& areas = model.areas();
  const Eigen::RowVector3d centre = areas.transpose() * model.nodes() / areas.sum();
  const double radius = std::sqrt(areas.sum() / (4 * 3.14159265358979323846));
  const Points arms = (model.nodes().rowwise() - centre) / radius;
  for (int k = 0; k < MotionBasis::affineColumns; ++k) {
    const Points moved =
        model.movedNodes(unitCoefficient(MotionBasis::localColumns + k)) - model.nodes();
    if (k < 3) {
      EXPECT_LT((moved.rowwise() - Eigen::RowVector3d::Unit(k)).cwiseAbs().maxCoeff(), 1e-12);
      continue;
    }
    // moved = arms G^T with G of Frobenius norm 1: symmetric for strain, antisymmetric for
    // rotation.
    const Eigen::Matrix3d g = arms.colPivHouseholderQr().solve(moved).transpose();
    EXPECT_LT((moved - arms * g.transpose()).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_NEAR(g.norm(), 1, 1e-10);
    const double sign = k < 9 ? 1 : -1;
    EXPECT_LT((g - sign * g.transpose()).norm(), 1e-10) << k;
  }
}

/// The local columns as they move the nodes: 3 #N by 240.
Eigen::MatrixXd localColumns(const MotionModel& model) {
  Eigen::MatrixXd factor(3 * model.nodes().rows(), MotionBasis::localColumns);
  for (int k = 0; k < MotionBasis::localColumns; ++k) {
    const Eigen::MatrixX3d moved = model.movedNodes(unitCoefficient(k)) - model.nodes();
    factor.col(k) = moved.reshaped<Eigen::RowMajor>();
  }
  return factor;
}

double radiusOf(const MotionModel& model) {
  return std::sqrt(model.areas().sum() / (4 * 3.14159265358979323846));
}

TEST(MotionModel, TwistsTurnOneEndAgainstTheOther) {
  const Ellipsoid e;
  const MotionModel model(e.map);
  const Eigen::MatrixXd twists = model.basis().twists();
  ASSERT_EQ(twists.cols(), 5);
  // S = diag(2, -1, -1) / sqrt(6) of the diagonal ones: about the long axis.
  Eigen::VectorXd c = Eigen::VectorXd::Zero(MotionBasis::columns);
  c.head(twists.rows()) = std::sqrt(0.75) * twists.col(0) + 0.5 * twists.col(1);
  const Points moved = model.movedNodes(c) - model.nodes(), &x = model.nodes();
  Points expected(x.rows(), 3);
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    expected.row(i) = x(i, 0) * Eigen::RowVector3d(0, x(i, 2), -x(i, 1));
  const double cosine = moved.cwiseProduct(expected).sum() / (moved.norm() * expected.norm());
  EXPECT_GT(cosine, 0.99);
}

TEST(MotionModel, LocalColumnsFactorTheKernel) {
  const Ellipsoid e;
  const MotionModel model(e.map);
  const Eigen::MatrixXd factor = localColumns(model);
  const double radius = radiusOf(model);
  double worst = 0;
  for (int i = 0; i < 1002; i += 13)
    for (int j = 0; j < 1002; j += 17) {
      const Vector3 r = (model.nodes().row(i) - model.nodes().row(j)).transpose() / radius;
      const Vector3 a = r / 0.5, b = r / 0.4;
      const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
      const Eigen::Matrix3d curlFree = (one - a * a.transpose()) * std::exp(-a.squaredNorm() / 2);
      const Eigen::Matrix3d divergenceFree =
          0.5 * (b * b.transpose() + (2 - b.squaredNorm()) * one) * std::exp(-b.squaredNorm() / 2);
      const Eigen::Matrix3d kernel = 0.45 * curlFree + 0.55 * divergenceFree;
      worst = std::max(
          worst, (kernel - factor.middleRows(3 * i, 3) * factor.middleRows(3 * j, 3).transpose())
                     .cwiseAbs()
                     .maxCoeff());
    }
  EXPECT_LT(worst, 0.1);
}

TEST(MotionModel, LocalColumnsTurnWithTheSurface) {
  const Ellipsoid e;
  Points uneven = e.surface.vertices();  // so that no two nodes are pivots alike
  for (auto x : uneven.rowwise()) x *= 1 + 0.002 * x[0] + 0.003 * x[1] - 0.004 * x[2];
  const Eigen::Matrix3d rotation = test::randomRotation(3);
  const ClosedSurface straight(uneven, e.surface.faces(), "straight");
  const ClosedSurface turned(uneven * rotation.transpose(), e.surface.faces(), "turned");
  const Eigen::MatrixXd here = localColumns(MotionModel(e.map.of(straight)));
  const Eigen::MatrixXd there = localColumns(MotionModel(e.map.of(turned)));
  for (int i = 0; i < 1002; i += 100)
    for (int k = 0; k < MotionBasis::localColumns; k += 3)
      EXPECT_LT((rotation * here.block<3, 3>(3 * i, k) * rotation.transpose() -
                 there.block<3, 3>(3 * i, k))
                    .norm(),
                1e-9);
}

TEST(MotionModel, VerticesMoveWithTheTemplate) {
  const Ellipsoid e;
  const MotionModel model(e.map);
  Eigen::VectorXd c = Eigen::VectorXd::Zero(MotionBasis::columns);
  c.segment<3>(MotionBasis::localColumns) << 3, -4, 5;
  const Points moved = model.movedVertices(c) - e.surface.vertices();
  EXPECT_LT((moved.rowwise() - Eigen::RowVector3d(3, -4, 5)).cwiseAbs().maxCoeff(), 1e-12);
}

}  // namespace
}  // namespace sphere_propagation
