#include "vcg_ext/propagation/motion_model.h"

#include <cmath>

#include "vcg_ext/map/sphere_locator.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

constexpr int frequency = 10;          // of the template's icosphere: 1002 nodes
constexpr double kernelLength = 0.35;  // in R; shorter loses hearts, longer loses walls

/// L with L L^T close to the Gaussian kernel: pivoted Cholesky, next the node with the largest unexplained variance x
/// area.
template <class Matrix>
Matrix kernelFactor(const Points& nodes, const Eigen::VectorXd& areas, double length) {
  Matrix factor = Matrix::Zero(nodes.rows(), Matrix::ColsAtCompileTime);
  Eigen::VectorXd rest = Eigen::VectorXd::Ones(nodes.rows());
  for (int k = 0; k < Matrix::ColsAtCompileTime; ++k) {
    Eigen::Index pivot = 0;
    rest.cwiseProduct(areas).maxCoeff(&pivot);
    if (!(rest[pivot] > 1e-12)) break;  // everything is explained
    const double root = std::sqrt(rest[pivot]);
    for (Eigen::Index i = 0; i < nodes.rows(); ++i) {
      const double kernel = std::exp(-(nodes.row(i) - nodes.row(pivot)).squaredNorm() / (2 * length * length));
      factor(i, k) = (kernel - factor.row(i).head(k).dot(factor.row(pivot).head(k))) / root;
    }
    rest = (rest - factor.col(k).cwiseAbs2()).cwiseMax(0);
  }
  return factor;
}

}  // namespace

MotionModel::MotionModel(const ClosedSurface& surface, const SphereMap& map) : vertices_(surface.vertices()) {
  const Icosphere sphere = icosphere(frequency);
  faces_ = sphere.faces;
  const SphereLocator surfaceUnder(surface, map);
  nodes_.resize(sphere.vertices.rows(), 3);
  for (Eigen::Index i = 0; i < nodes_.rows(); ++i)
    nodes_.row(i) = surfaceUnder.locate(sphere.vertices.row(i).transpose())
                        .interpolate(surface.faces(), surface.vertices())
                        .transpose();
  areas_ = vertexAreas(nodes_, faces_);
  const double radius = std::sqrt(areas_.sum() / (4 * pi));
  meanVertexArea_ = faceAreas(surface.vertices(), surface.faces()).sum() / surface.vertexCount();

  kernel_ = kernelFactor<decltype(kernel_)>(nodes_, areas_, kernelLength * radius);
  const Eigen::RowVector3d centre = (areas_.transpose() * nodes_) / areas_.sum();
  arms_ = (nodes_.rowwise() - centre) / radius;

  const ClosedSurface icosphereSurface(sphere.vertices, sphere.faces, "icosphere");
  const SphereLocator templateUnder(icosphereSurface, SphereMap(icosphereSurface, sphere.vertices));
  site_.reserve(static_cast<size_t>(surface.vertexCount()));
  for (int v = 0; v < surface.vertexCount(); ++v) site_.push_back(templateUnder.locate(map.position(v)));
}

void MotionModel::project(int i, const Vector3& m, double* row) const {
  for (int k = 0; k < kernelColumns; ++k)
    for (int a = 0; a < 3; ++a) *row++ = kernel_(i, k) * m[a];
  const Vector3 y = arms_.row(i).transpose();
  for (int a = 0; a < 3; ++a) *row++ = m[a];
  for (int a = 0; a < 3; ++a) *row++ = m[a] * y[a];
  constexpr double half = 0.70710678118654752440;  // the six matrices of strain and three of rotation are orthonormal
  for (int a = 0; a < 2; ++a)
    for (int b = a + 1; b < 3; ++b) *row++ = half * (m[a] * y[b] + m[b] * y[a]);
  for (int a = 0; a < 2; ++a)
    for (int b = a + 1; b < 3; ++b) *row++ = half * (m[a] * y[b] - m[b] * y[a]);
}

Points MotionModel::displacements(const Eigen::VectorXd& c) const {
  using Local = Eigen::Map<const Eigen::Matrix<double, kernelColumns, 3, Eigen::RowMajor>>;
  Points moved = kernel_ * Local(c.data());
  const double* a = c.data() + localColumns;
  constexpr double half = 0.70710678118654752440;
  Eigen::Matrix3d linear = Eigen::Vector3d(a[3], a[4], a[5]).asDiagonal();
  int k = 6;
  for (int i = 0; i < 2; ++i)
    for (int j = i + 1; j < 3; ++j, ++k) {
      linear(i, j) = half * (a[k] + a[k + 3]);
      linear(j, i) = half * (a[k] - a[k + 3]);
    }
  moved += arms_ * linear.transpose();
  moved.rowwise() += Eigen::RowVector3d(a[0], a[1], a[2]);
  return moved;
}

Points MotionModel::movedNodes(const Eigen::VectorXd& c) const { return nodes_ + displacements(c); }

Points MotionModel::movedVertices(const Eigen::VectorXd& c) const {
  const Points moved = displacements(c);
  Points vertices = vertices_;
  for (Eigen::Index v = 0; v < vertices.rows(); ++v)
    vertices.row(v) += site_[static_cast<size_t>(v)].interpolate(faces_, moved).transpose();
  return vertices;
}

}  // namespace sphere_propagation
