// SPDX-License-Identifier: GPL-3.0-only
// The tree is nanoflann's: J. L. Blanco and P. K. Rai, nanoflann: a C++ header-only fork of FLANN,
// 2014.

#include "vcg_ext/mesh/vertex_locator.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <nanoflann.hpp>
#include <utility>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

/// nanoflann's result set: the nearest point, of several the one with the smallest index.
class Nearest {
 public:
  Nearest() = default;
  Nearest(double squaredDistance, int index) : squaredDistance_(squaredDistance), index_(index) {}

  bool addPoint(double squaredDistance, std::uint32_t index) {
    const int i = static_cast<int>(index);
    if (squaredDistance < squaredDistance_ || (squaredDistance == squaredDistance_ && i < index_)) {
      squaredDistance_ = squaredDistance;
      index_ = i;
    }
    return true;
  }
  /// A little more than the best, so that equally near points are seen in spite of the rounding of
  /// the tree's bounds.
  double worstDist() const {
    return squaredDistance_ * (1 + 1e-12) + std::numeric_limits<double>::min();
  }
  bool full() const { return index_ != std::numeric_limits<int>::max(); }
  bool empty() const { return !full(); }
  std::size_t size() const { return full() ? 1 : 0; }
  void sort() {}
  int index() const { return index_; }

 private:
  double squaredDistance_ = std::numeric_limits<double>::max();
  int index_ = std::numeric_limits<int>::max();
};

}  // namespace

struct VertexLocator::Tree {
  /// nanoflann's view of the points.
  struct Cloud {
    Points points;
    std::size_t kdtree_get_point_count() const { return static_cast<std::size_t>(points.rows()); }
    double kdtree_get_pt(std::size_t i, std::size_t k) const {
      return points(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
    }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
      return false;
    }
  };
  using Metric = nanoflann::L2_Simple_Adaptor<double, Cloud>;
  using Index = nanoflann::KDTreeSingleIndexAdaptor<Metric, Cloud, 3, std::uint32_t>;
  static constexpr std::size_t leafSize = 10;

  explicit Tree(Points points)
      : cloud{std::move(points)},
        index(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(leafSize)) {}
  Cloud cloud;
  Index index;  // refers to cloud
};

VertexLocator::VertexLocator(Points points) {
  if (points.rows() == 0) throw ArgumentError("There is no vertex to search among.");
  tree_ = std::make_unique<Tree>(std::move(points));
}

VertexLocator::~VertexLocator() = default;
VertexLocator::VertexLocator(VertexLocator&&) noexcept = default;
VertexLocator& VertexLocator::operator=(VertexLocator&&) noexcept = default;

const Points& VertexLocator::points() const { return tree_->cloud.points; }

int VertexLocator::nearest(const Vector3& x, int guess) const {
  Nearest result;
  // The metric's own sum, so that the guess is compared with itself without a rounding difference.
  if (guess >= 0)
    result = Nearest(
        tree_->index.distance.evalMetric(x.data(), static_cast<std::uint32_t>(guess), 3), guess);
  tree_->index.findNeighbors(result, x.data(), {});
  return result.index();
}

std::vector<int> VertexLocator::nearest(const Points& queries,
                                        const std::vector<int>& guesses) const {
  std::vector<int> indices(static_cast<std::size_t>(queries.rows()));
  for (std::size_t i = 0; i < indices.size(); ++i)
    indices[i] = nearest(Vector3(queries.row(static_cast<Eigen::Index>(i)).transpose()),
                         guesses.empty() ? -1 : guesses[i]);
  return indices;
}

std::vector<std::vector<int>> VertexLocator::neighbours(int count) const {
  const Points& all = points();
  const std::size_t asked =
      std::min(static_cast<std::size_t>(count) + 1, static_cast<std::size_t>(all.rows()));
  std::vector<std::uint32_t> found(asked);
  std::vector<double> distances(asked);
  std::vector<std::vector<int>> lists(static_cast<std::size_t>(all.rows()));
  for (std::size_t i = 0; i < lists.size(); ++i) {
    const Vector3 x = all.row(static_cast<Eigen::Index>(i)).transpose();
    tree_->index.knnSearch(x.data(), asked, found.data(), distances.data());
    for (const std::uint32_t other : found)
      if (other != i && lists[i].size() + 1 < asked) lists[i].push_back(static_cast<int>(other));
  }
  return lists;
}

}  // namespace sphere_propagation
