// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_data.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "vcg_ext/base/statistics.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

constexpr double minAgreement =
    0.5;                      // least dot product of a surface's face normal with the template's
constexpr int coarse = 3000;  // vertices

/// How many vertices a surface's noise is taken for. That of few is partly theirs, as that of large
/// voxels, and partly of the shape, which is as smooth on a coarse mesh as on a fine one: the
/// geometric mean with `coarse` stands between.
double countedVertices(int count) {
  return count < coarse ? std::sqrt(static_cast<double>(count) * coarse) : count;
}

}  // namespace

MotionData motionDataAt(const MotionModel& model, const PreparedSurface& target,
                        const Eigen::VectorXd& c, std::vector<int>& nearby) {
  const Points moved = model.roughMovedNodes(c), normals = vertexNormals(moved, model.faces());
  const Eigen::Index count = moved.rows();
  std::vector<SurfacePoint> closest(static_cast<size_t>(count));
  std::vector<double> distances;
  distances.reserve(closest.size());
  const SurfaceLocator& locator = target.locator();
  int last = -1;  // nodes that follow each other are often neighbours
  for (Eigen::Index i = 0; i < count; ++i) {
    SurfacePoint& point = closest[static_cast<size_t>(i)];
    int& near = nearby[static_cast<size_t>(i)];
    point = locator.closest(moved.row(i).transpose(), normals.row(i).transpose(), minAgreement,
                            near >= 0 ? near : last);
    near = last = point.face;
    if (point.face >= 0) distances.push_back(point.distance);
  }
  const double vertexArea = target.area() / countedVertices(target.surface().vertexCount());
  const double scale = std::max(4 * medianOf(distances), target.meanEdge());
  const double unit = 0.5 * model.meanVertexArea() / (vertexArea * vertexArea);
  const double mean = std::accumulate(distances.begin(), distances.end(), 0.0) /
                      static_cast<double>(distances.size());
  MotionData data{moved,
                  Eigen::VectorXd::Zero(count),
                  Points::Zero(count, 3),
                  Eigen::VectorXd::Zero(count),
                  Points::Zero(count, 3),
                  mean};
  for (Eigen::Index i = 0; i < count; ++i) {
    const SurfacePoint& point = closest[static_cast<size_t>(i)];
    if (point.face < 0) continue;
    const Vector3 m = point.interpolate(target.surface().faces(), target.normals()).normalized();
    const Vector3 p = point.interpolate(target.surface().faces(), target.surface().vertices());
    const double robust = 1 / (1 + (point.distance / scale) * (point.distance / scale));
    data.weights[i] = unit * model.areas()[i] * robust;
    data.directions.row(i) = m.transpose();
    data.offsets[i] = m.dot(p - moved.row(i).transpose());
    data.pull.row(i) = data.weights[i] * data.offsets[i] * m.transpose();
  }
  return data;
}

}  // namespace sphere_propagation
