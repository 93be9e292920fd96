// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/preparation/handle_removal.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/volume/volume_surface.h"

namespace sphere_propagation {
namespace {

/// On which side of the line from a to b a point lies; the same for both faces at the edge, so that
/// a ray through it meets one of them.
bool isLeft(const Points& vertices, int a, int b, const Vector2& p) {
  const bool turned = a > b;
  if (turned) std::swap(a, b);
  const Vector2 from = vertices.row(a).tail<2>().transpose(),
                to = vertices.row(b).tail<2>().transpose();
  const double side = (to[0] - from[0]) * (p[1] - from[1]) - (to[1] - from[1]) * (p[0] - from[0]);
  return (side >= 0) != turned;
}

/// The voxels whose centres the surface encloses, one row along x after another.
LabelGrid volumeOf(const Points& vertices, const Triangles& faces, double size) {
  const Vector3 low = vertices.colwise().minCoeff(), high = vertices.colwise().maxCoeff();
  constexpr double border = 2.5;
  LabelGrid grid;
  grid.size = ((high - low) / size).array().ceil().cast<int>() + static_cast<int>(2 * border);
  grid.values.assign(grid.voxelCount(), 0);
  const Vector3 origin =
      0.5 * (low + high) - 0.5 * size * (grid.size.cast<double>().array() - 1).matrix();
  grid.toWorld.topLeftCorner<3, 3>() *= size;
  grid.toWorld.topRightCorner<3, 1>() = origin;
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    std::array<Vector3, 3> p;
    for (int k = 0; k < 3; ++k) p[k] = (vertices.row(faces(f, k)).transpose() - origin) / size;
    const Vector3 least = p[0].cwiseMin(p[1]).cwiseMin(p[2]),
                  most = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
    const Vector3 normal = (p[1] - p[0]).cross(p[2] - p[0]);
    for (int k = static_cast<int>(std::floor(least[2])); k <= static_cast<int>(std::ceil(most[2]));
         ++k)
      for (int j = static_cast<int>(std::floor(least[1]));
           j <= static_cast<int>(std::ceil(most[1])); ++j) {
        const Vector2 at(origin[1] + size * j, origin[2] + size * k);
        std::array<bool, 3> left{};
        for (int e = 0; e < 3; ++e)
          left[e] = isLeft(vertices, faces(f, e), faces(f, (e + 1) % 3), at);
        if (left[0] != left[1] || left[1] != left[2]) continue;
        double x = (least[0] + most[0]) / 2;
        if (std::fabs(normal[0]) > 0)
          x = p[0][0] - (normal[1] * (j - p[0][1]) + normal[2] * (k - p[0][2])) / normal[0];
        x = std::clamp(x, least[0], most[0]);
        grid(static_cast<int>(std::floor(x)) + 1, j, k) ^= 1;  // the first centre behind it
      }
  }
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 1; i < grid.size[0]; ++i) grid(i, j, k) ^= grid(i - 1, j, k);
  return grid;
}

}  // namespace

RemadeSurface withoutHandles(const Points& vertices, const Triangles& faces, double voxelSize,
                             const Progress& progress) {
  constexpr double most = 1e7;
  RemadeSurface result;
  result.voxelSize = voxelSize;
  if (voxelSize <= 0) {
    const Vector3 extent = vertices.colwise().maxCoeff() - vertices.colwise().minCoeff();
    result.voxelSize =
        std::max(0.75 * meanEdgeLength(vertices, faces), std::cbrt(extent.prod() / most));
  }
  VolumeSurface made =
      volumeSurface(volumeOf(vertices, faces, result.voxelSize), {}, part(progress, 0, 0.9));
  result.vertices = std::move(made.vertices);
  result.faces = std::move(made.faces);
  result.handles = made.handles.handles;
  result.changedVoxels = made.handles.changedVoxels;
  const SurfaceLocator former(vertices, faces);
  for (Eigen::Index v = 0; v < result.vertices.rows(); ++v)
    result.nearest.push_back(former.closest(result.vertices.row(v).transpose()).face);
  return result;
}

}  // namespace sphere_propagation
