// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Nearest vertices.

#include <memory>
#include <vector>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// A kd-tree over points; built once, asked often. Of equally near points it always answers the
/// smallest index, so that results do not depend on how the tree was built.
class VertexLocator {
 public:
  /// points: #P by 3, #P >= 1, finite; copied. Throws ParameterError when there is no point.
  explicit VertexLocator(Points points);
  ~VertexLocator();
  VertexLocator(const VertexLocator&) = delete;
  VertexLocator& operator=(const VertexLocator&) = delete;
  VertexLocator(VertexLocator&&) noexcept;
  VertexLocator& operator=(VertexLocator&&) noexcept;

  const Points& points() const;

  /// Index of the point nearest to x.
  /// guess: a point that may be near (the answer of a query close by); it makes the search faster,
  /// never different.
  int nearest(const Vector3& x, int guess = -1) const;

  /// Index of the nearest point for each row of queries (#Q by 3).
  /// guesses: empty, or one per query as above.
  std::vector<int> nearest(const Points& queries, const std::vector<int>& guesses = {}) const;

  /// For each point the `count` other points nearest to it, or all others where they are fewer. A
  /// point in the same place is another.
  std::vector<std::vector<int>> neighbours(int count) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace sphere_propagation
