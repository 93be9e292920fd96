#include "vcg_ext/propagation/similarity_tree.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/mesh/vertex_locator.h"
#include "vcg_ext/propagation/rigid_alignment.h"

namespace sphere_propagation {
namespace {

constexpr int samples = 100, samplesToChooseBy = 50;
constexpr int alignmentIterations = 10;

/// What the comparison needs of a layer: centre and axes of its surface (not of its vertices, which lie as the mesh
/// likes), a few vertices that are spread evenly, and the locators.
struct Shape {
  Vector3 centre;
  Eigen::Matrix3d axes;  // columns, by falling variance, right-handed
  Points spread;         // about the centre
  VertexLocator vertices;
  SurfaceLocator surface;
};

/// Vertices each as far as possible from those before; the first is the one farthest from the centre.
Points spreadOver(const Points& points) {
  const auto count = std::min<Eigen::Index>(samples, points.rows());
  Points spread(count, 3);
  Eigen::Index next = 0;
  points.rowwise().squaredNorm().maxCoeff(&next);
  Eigen::VectorXd distance = Eigen::VectorXd::Constant(points.rows(), std::numeric_limits<double>::infinity());
  for (Eigen::Index i = 0; i < count; ++i) {
    spread.row(i) = points.row(next);
    for (Eigen::Index j = 0; j < points.rows(); ++j)
      distance[j] = std::min(distance[j], (points.row(j) - spread.row(i)).squaredNorm());
    distance.maxCoeff(&next);
  }
  return spread;
}

Shape shapeOf(const ClosedSurface& surface) {
  Eigen::VectorXd weights = vertexAreas(surface.vertices(), surface.faces());
  weights /= weights.sum();
  const Eigen::RowVector3d centre = weights.transpose() * surface.vertices();
  const Points centred = surface.vertices().rowwise() - centre;
  const Eigen::Matrix3d covariance = centred.transpose() * weights.asDiagonal() * centred;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);  // ascending
  Eigen::Matrix3d axes;
  axes.col(0) = solver.eigenvectors().col(2);
  axes.col(1) = solver.eigenvectors().col(1);
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return {centre.transpose(), axes, spreadOver(centred), VertexLocator(centred),
          SurfaceLocator(centred, surface.faces())};
}

/// Sum of the squared distances of the moved points from the nearest vertices of `to`.
double misfit(const Points& moved, const Shape& to) {
  const std::vector<int> nearest = to.vertices.nearest(moved);
  double sum = 0;
  for (size_t i = 0; i < nearest.size(); ++i)
    sum += (moved.row(static_cast<Eigen::Index>(i)) - to.vertices.points().row(nearest[i])).squaredNorm();
  return sum;
}

/// The rigid motion from one shape to another, both about their centres.
RigidMotion motionBetween(const Shape& from, const Shape& to) {
  // The pose that both have, and those that lay axes on axes: proper rotations are those of an even number of signs.
  // The first of the spread vertices are themselves spread, and enough to choose by.
  const Points few = from.spread.topRows(std::min<Eigen::Index>(samplesToChooseBy, from.spread.rows()));
  Eigen::Matrix3d start = Eigen::Matrix3d::Identity();
  double least = misfit(few, to);
  for (const Vector3& sign : {Vector3(1, 1, 1), Vector3(1, -1, -1), Vector3(-1, 1, -1), Vector3(-1, -1, 1)}) {
    const Eigen::Matrix3d rotation = to.axes * sign.asDiagonal() * from.axes.transpose();
    const double sum = misfit(few * rotation.transpose(), to);
    if (sum >= least) continue;
    least = sum;
    start = rotation;
  }
  const RigidMotion refined = alignRigidly(from.spread * start.transpose(), to.vertices, alignmentIterations).motion;
  return {refined.rotation * start, refined.translation};
}

double rootMeanSquare(const Points& points, const SurfaceLocator& surface) {
  double sum = 0;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double distance = surface.closest(points.row(i).transpose()).distance;
    sum += distance * distance;
  }
  return std::sqrt(sum / static_cast<double>(points.rows()));
}

double distanceBetween(const Shape& a, const Shape& b) {
  const RigidMotion motion = motionBetween(a, b);
  const RigidMotion back{motion.rotation.transpose(), -motion.rotation.transpose() * motion.translation};
  return (rootMeanSquare(motion.applyTo(a.spread), b.surface) + rootMeanSquare(back.applyTo(b.spread), a.surface)) / 2;
}

}  // namespace

Eigen::MatrixXd shapeDistances(const std::vector<ClosedSurface>& surfaces) {
  std::vector<Shape> shapes;
  shapes.reserve(surfaces.size());
  for (const ClosedSurface& surface : surfaces) shapes.push_back(shapeOf(surface));
  const auto count = static_cast<Eigen::Index>(shapes.size());
  Eigen::MatrixXd distances = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < i; ++j)
      distances(i, j) = distances(j, i) =
          distanceBetween(shapes[static_cast<size_t>(i)], shapes[static_cast<size_t>(j)]);
  return distances;
}

PropagationTree minimumSpanningTree(const Eigen::MatrixXd& distances, int root) {
  const int layers = static_cast<int>(distances.rows());
  if (distances.cols() != layers || !distances.allFinite() || distances != distances.transpose())
    throw ParameterError(
        "Distances between layers form a square, symmetric matrix of finite numbers; given is one of " +
        std::to_string(distances.rows()) + " by " + std::to_string(distances.cols()) + ".");
  PropagationTree tree = star(layers, root);  // which checks the root
  tree.order = {root};
  std::vector<char> reached(static_cast<size_t>(layers), 0);
  reached[root] = 1;
  while (static_cast<int>(tree.order.size()) < layers) {
    int next = -1;
    for (int i = 0; i < layers; ++i)
      if (!reached[i] && (next < 0 || distances(i, tree.parent[i]) < distances(next, tree.parent[next]))) next = i;
    reached[next] = 1;
    tree.order.push_back(next);
    for (int i = 0; i < layers; ++i) {
      if (reached[i]) continue;
      const double now = distances(i, tree.parent[i]), by = distances(i, next);
      if (by < now || (by == now && next < tree.parent[i])) tree.parent[i] = next;
    }
  }
  return tree;
}

SimilarityTree similarityTree(const std::vector<ClosedSurface>& surfaces, int root) {
  star(static_cast<int>(surfaces.size()), root);  // checks the root before the work
  Eigen::MatrixXd distances = shapeDistances(surfaces);
  PropagationTree tree = minimumSpanningTree(distances, root);
  return {std::move(tree), std::move(distances)};
}

}  // namespace sphere_propagation
