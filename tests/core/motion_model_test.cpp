#include "vcg_ext/propagation/motion_model.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/core/test_meshes.h"

namespace sphere_propagation {
namespace {

struct Ellipsoid {
  ClosedSurface surface;
  SphereMap map;
  Ellipsoid() : Ellipsoid(test::icosphereMesh(9)) {}

 private:
  explicit Ellipsoid(const test::Mesh& sphere)
      : surface(sphere.vertices * Vector3(40, 25, 20).asDiagonal(), sphere.faces, "ellipsoid"),
        map(surface, sphere.vertices) {}
};

Eigen::VectorXd unitCoefficient(int column) { return Eigen::VectorXd::Unit(MotionModel::columns, column); }

Eigen::VectorXd someCoefficients(unsigned seed) {
  test::Random random(seed);
  Eigen::VectorXd c(MotionModel::columns);
  for (double& x : c) x = random.uniform(-1, 1);
  return c;
}

TEST(MotionModel, ZeroCoefficientsMoveNothing) {
  const Ellipsoid e;
  const MotionModel model(e.surface, e.map);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(MotionModel::columns);
  EXPECT_EQ(model.movedNodes(zero), model.nodes());
  EXPECT_EQ(model.movedVertices(zero), e.surface.vertices());
  EXPECT_EQ(model.nodes().rows(), 1002);
}

TEST(MotionModel, ProjectionIsTheTransposedDisplacement) {
  const Ellipsoid e;
  const MotionModel model(e.surface, e.map);
  const Eigen::VectorXd c = someCoefficients(1);
  const Points moved = model.movedNodes(c) - model.nodes();
  Eigen::VectorXd row(MotionModel::columns);
  for (int i : {0, 17, 500, 1001}) {
    const Vector3 m = Vector3(1, -2, 0.5).normalized();
    model.project(i, m, row.data());
    EXPECT_NEAR(row.dot(c), m.dot(moved.row(i).transpose()), 1e-12);
  }
}

TEST(MotionModel, AffineColumnsTranslateStrainAndRotate) {
  const Ellipsoid e;
  const MotionModel model(e.surface, e.map);
  const Eigen::VectorXd& areas = model.areas();
  const Eigen::RowVector3d centre = areas.transpose() * model.nodes() / areas.sum();
  const double radius = std::sqrt(areas.sum() / (4 * 3.14159265358979323846));
  const Points arms = (model.nodes().rowwise() - centre) / radius;
  for (int k = 0; k < MotionModel::affineColumns; ++k) {
    const Points moved = model.movedNodes(unitCoefficient(MotionModel::localColumns + k)) - model.nodes();
    if (k < 3) {
      EXPECT_LT((moved.rowwise() - Eigen::RowVector3d::Unit(k)).cwiseAbs().maxCoeff(), 1e-12);
      continue;
    }
    // moved = arms G^T with G of Frobenius norm 1: symmetric for strain, antisymmetric for rotation.
    const Eigen::Matrix3d g = arms.colPivHouseholderQr().solve(moved).transpose();
    EXPECT_LT((moved - arms * g.transpose()).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_NEAR(g.norm(), 1, 1e-10);
    const double sign = k < 9 ? 1 : -1;
    EXPECT_LT((g - sign * g.transpose()).norm(), 1e-10) << k;
  }
}

TEST(MotionModel, LocalColumnsFactorTheKernel) {
  const Ellipsoid e;
  const MotionModel model(e.surface, e.map);
  Eigen::MatrixXd factor(model.nodes().rows(), MotionModel::kernelColumns);
  for (int k = 0; k < MotionModel::kernelColumns; ++k)
    factor.col(k) = (model.movedNodes(unitCoefficient(3 * k)) - model.nodes()).col(0);
  const double radius = std::sqrt(model.areas().sum() / (4 * 3.14159265358979323846));
  const double twoSquares = 2 * 0.35 * 0.35 * radius * radius;
  double worst = 0;
  for (int i = 0; i < 1002; i += 13)
    for (int j = 0; j < 1002; j += 17) {
      const double kernel = std::exp(-(model.nodes().row(i) - model.nodes().row(j)).squaredNorm() / twoSquares);
      worst = std::max(worst, std::fabs(kernel - factor.row(i).dot(factor.row(j))));
    }
  EXPECT_LT(worst, 0.1);
}

TEST(MotionModel, VerticesMoveWithTheTemplate) {
  const Ellipsoid e;
  const MotionModel model(e.surface, e.map);
  Eigen::VectorXd c = Eigen::VectorXd::Zero(MotionModel::columns);
  c.segment<3>(MotionModel::localColumns) << 3, -4, 5;
  const Points moved = model.movedVertices(c) - e.surface.vertices();
  EXPECT_LT((moved.rowwise() - Eigen::RowVector3d(3, -4, 5)).cwiseAbs().maxCoeff(), 1e-12);
}

}  // namespace
}  // namespace sphere_propagation
