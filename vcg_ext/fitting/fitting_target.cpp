// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/fitting/fitting_target.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/mesh/usable_extent.h"

namespace sphere_propagation {
namespace {

/// Normals of the vertices, averaged over rings.
Points smoothNormals(const Points& vertices, const Triangles& faces, int rings) {
  Points normals = vertexNormals(vertices, faces);
  for (int ring = 0; ring < rings; ++ring) {
    Points sum = normals;
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
      for (int k = 0; k < 3; ++k) {
        sum.row(faces(f, k)) += normals.row(faces(f, (k + 1) % 3));
        sum.row(faces(f, (k + 1) % 3)) += normals.row(faces(f, k));
      }
    sum.rowwise().normalize();
    normals = std::move(sum);
  }
  return normals;
}

}  // namespace

std::vector<char> facesAtEdge(const Triangles& faces) {
  std::vector<std::array<int, 2>> edges;
  edges.reserve(static_cast<size_t>(faces.size()));
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, k), b = faces(f, (k + 1) % 3);
      edges.push_back({std::min(a, b), std::max(a, b)});
    }
  std::sort(edges.begin(), edges.end());
  std::vector<char> rim(static_cast<size_t>(faces.size() > 0 ? faces.maxCoeff() + 1 : 0), 0);
  for (size_t i = 0; i < edges.size();) {
    size_t end = i + 1;
    while (end < edges.size() && edges[end] == edges[i]) ++end;
    if (end == i + 1)
      for (const int v : edges[i]) rim[static_cast<size_t>(v)] = 1;
    i = end;
  }
  std::vector<char> at(static_cast<size_t>(faces.rows()), 0);
  for (size_t f = 0; f < at.size(); ++f)
    for (int k = 0; k < 3; ++k)
      if (rim[static_cast<size_t>(faces(static_cast<Eigen::Index>(f), k))]) at[f] = 1;
  return at;
}

FittingTarget::UsedMesh FittingTarget::usedPartOf(const Points& vertices, const Triangles& faces,
                                                  const std::string& name) {
  if (vertices.rows() == 0 && faces.rows() == 0) throw SurfaceError(Finding(Fault::Empty, name));
  if (faces.rows() == 0) throw SurfaceError(Finding(Fault::NoFaces, name).of(vertices.rows()));
  long outside = 0, firstOutside = -1;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    if (faces.row(f).minCoeff() < 0 || faces.row(f).maxCoeff() >= vertices.rows()) {
      if (outside++ == 0) firstOutside = f;
    }
  if (outside > 0)
    throw SurfaceError(Finding(Fault::IndexOutOfRange, name).of(outside, firstOutside));
  std::vector<int> place(static_cast<size_t>(vertices.rows()), -1);
  UsedMesh used{Points(vertices.rows(), 3), faces};
  int count = 0;
  for (int& corner : used.faces.reshaped()) {
    int& at = place[static_cast<size_t>(corner)];
    if (at < 0) {
      at = count++;
      used.vertices.row(at) = vertices.row(corner);
    }
    corner = at;
  }
  used.vertices.conservativeResize(count, 3);
  long infinite = 0, first = -1;
  for (size_t v = 0; v < place.size(); ++v)
    if (place[v] >= 0 && !vertices.row(static_cast<Eigen::Index>(v)).allFinite()) {
      if (infinite++ == 0) first = static_cast<long>(v);
    }
  if (infinite > 0)
    throw SurfaceError(Finding(Fault::NonFiniteCoordinate, name).of(infinite, first));
  requireUsableExtent(used.vertices, name);
  if (!(faceAreas(used.vertices, used.faces).sum() > 0))
    throw SurfaceError(Finding(Fault::ZeroArea, name).of(used.faces.rows()));
  return used;
}

FittingTarget::FittingTarget(const Points& vertices, const Triangles& faces,
                             const std::string& name)
    : FittingTarget(usedPartOf(vertices, faces, name), name) {}

FittingTarget::FittingTarget(UsedMesh used, const std::string& name)
    : vertices_(std::move(used.vertices)),
      faces_(std::move(used.faces)),
      locator_(vertices_, faces_),
      atEdge_(facesAtEdge(faces_)) {
  closed_ = std::find(atEdge_.begin(), atEdge_.end(), 1) == atEdge_.end();
  if (closed_ && enclosedVolume(vertices_, faces_) < 0)
    throw SurfaceError(Finding(Fault::InwardOrientation, name));
  const Eigen::VectorXd areas = faceAreas(vertices_, faces_);
  area_ = areas.sum();
  meanEdge_ = meanEdgeLength(vertices_, faces_);
  centre_.setZero();
  for (Eigen::Index f = 0; f < faces_.rows(); ++f)
    for (int k = 0; k < 3; ++k) centre_ += areas[f] / 3 * vertices_.row(faces_(f, k)).transpose();
  centre_ /= area_;
  sample(areas);
}

FittingTarget FittingTarget::mirrored() const {
  UsedMesh image{vertices_, faces_};
  image.vertices.col(0) = (2 * centre_[0] - image.vertices.col(0).array()).matrix();
  image.faces.col(1).swap(image.faces.col(2));
  return {std::move(image), "mirror image"};
}

// Along the order of the tree, in which what is near in space is near, at equal steps of area.
void FittingTarget::sample(const Eigen::VectorXd& areas) {
  constexpr int rings = 2;
  const Points normals = smoothNormals(vertices_, faces_, rings);
  const std::vector<int> order = locator_.order();
  double total = 0;
  for (const int f : order) total += atEdge_[static_cast<size_t>(f)] ? 0 : areas[f];
  std::vector<int> chosen;
  double sum = 0;
  int step = 0;  // a face that is larger than a step is taken once
  for (const int f : order) {
    if (atEdge_[static_cast<size_t>(f)]) continue;
    sum += areas[f];
    const int before = step;
    while (step < sampleCount && sum >= total * (step + 0.5) / sampleCount) ++step;
    if (step > before) chosen.push_back(f);
  }
  const auto count = static_cast<Eigen::Index>(chosen.size());
  samples_.resize(count, 3);
  sampleNormals_.resize(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const int f = chosen[static_cast<size_t>(i)];
    samples_.row(i).setZero();
    sampleNormals_.row(i).setZero();
    for (int k = 0; k < 3; ++k) {
      samples_.row(i) += vertices_.row(faces_(f, k)) / 3;
      sampleNormals_.row(i) += normals.row(faces_(f, k));
    }
    sampleNormals_.row(i).normalize();
  }
}

SurfacePoint FittingTarget::closest(const Vector3& x, const Vector3& normal, int& near) const {
  SurfacePoint found = locator_.closest(x, normal, agreement, near);
  near = found.face;
  if (found.face >= 0 && atEdge_[static_cast<size_t>(found.face)]) found.face = -1;
  return found;
}

}  // namespace sphere_propagation
