// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A surface with what registration and fitting ask of it.

#include <memory>
#include <vector>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/mesh/vertex_locator.h"

namespace sphere_propagation {

/// Sizes are computed when it is made, the rest once, when it is first asked for.
/// Immutable, cheap to copy (copies share what they hold), and may be asked by several threads.
class PreparedSurface {
 public:
  explicit PreparedSurface(ClosedSurface surface);

  const ClosedSurface& surface() const;
  double area() const;
  double radius() const;          ///< of the sphere of the same area
  double volume() const;          ///< enclosed
  double meanEdge() const;        ///< length
  const Vector3& centre() const;  ///< by area: vertices lie as the mesh likes
  const Points& normals() const;  ///< of the vertices, #V by 3
  /// Principal axes by area: columns, the largest variance first, right-handed.
  const Eigen::Matrix3d& axes() const;
  /// About 100 vertices, each as far as possible from those before: #S by 3.
  const Points& samples() const;
  const Points& sampleNormals() const;
  const VertexLocator& vertexLocator() const;
  const SurfaceLocator& locator() const;

  /// Makes all of it now.
  void prepare() const;

 private:
  const std::vector<int>& sampleVertices() const;

  struct Data;
  std::shared_ptr<const Data> data_;
};

}  // namespace sphere_propagation
