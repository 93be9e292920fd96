// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/outliers.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "vcg_ext/base/statistics.h"
#include "vcg_ext/base/unit_ratio.h"
#include "vcg_ext/mesh/vertex_locator.h"

namespace sphere_propagation {
namespace {

constexpr size_t fewest = 5;                        // shapes that can tell which of them is apart
constexpr double far = 4, twice = 2;                // times the usual
constexpr double anotherSize = 1.8, groups = 3;     // factors
constexpr double visible = 0.02, unlike = 0.5;      // shares of the shape's size
constexpr double farOfOne = 6, visibleOfOne = 0.1;  // the same of one landmark
constexpr int around = 6;                           // neighbours that tell where one is
constexpr size_t fewStrays = 10;
constexpr double same = 1e-5;  // of the shape's size
constexpr double abrupt = 8;   // times what these are from where theirs say

/// Without some of them, which stray.
double radius(const Points& points, const std::vector<int>& strays = {}) {
  Points others(points.rows() - static_cast<Eigen::Index>(strays.size()), 3);
  Eigen::Index next = 0;
  for (Eigen::Index j = 0; j < points.rows(); ++j)
    if (std::find(strays.begin(), strays.end(), static_cast<int>(j)) == strays.end())
      others.row(next++) = points.row(j);
  const Points centred = others.rowwise() - others.colwise().mean();
  return std::sqrt(centred.rowwise().squaredNorm().mean());
}

/// Root mean square over the landmarks, the shape being taken in the size that fits best.
double distanceInSize(const Points& shape, const Points& middle) {
  const Eigen::RowVector3d centroid = shape.colwise().mean(), to = middle.colwise().mean();
  Points away = shape.rowwise() - centroid;
  const Points target = middle.rowwise() - to;
  const double squares = away.squaredNorm();
  if (squares > 0) away *= std::max(0.0, away.cwiseProduct(target).sum() / squares);
  return std::sqrt((away - target).rowwise().squaredNorm().mean() + (centroid - to).squaredNorm());
}

Points medianShape(const std::vector<TrainingSet::Shape>& shapes) {
  Points median(shapes.front().landmarks.rows(), 3);
  std::vector<double> values(shapes.size());
  for (Eigen::Index i = 0; i < median.size(); ++i) {
    for (size_t k = 0; k < shapes.size(); ++k) values[k] = shapes[k].landmarks.data()[i];
    median.data()[i] = lowerQuantileOf(values, 0.5);
  }
  return median;
}

/// The sizes without those of groups that differ from the largest one as units do.
std::vector<double> inOneUnit(const std::vector<double>& sizes) {
  std::vector<size_t> order(sizes.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return sizes[a] < sizes[b]; });
  std::vector<std::vector<size_t>> clusters;
  for (const size_t k : order) {
    const bool apart = !clusters.empty() && sizes[clusters.back().back()] > 0 &&
                       sizes[k] >= groups * sizes[clusters.back().back()];
    if (clusters.empty() || apart) clusters.emplace_back();
    clusters.back().push_back(k);
  }
  const auto lowest = [](const std::vector<size_t>& cluster) {
    return *std::min_element(cluster.begin(), cluster.end());
  };
  const auto& largest =
      *std::max_element(clusters.begin(), clusters.end(),
                        [&](const std::vector<size_t>& a, const std::vector<size_t>& b) {
                          return a.size() != b.size() ? a.size() < b.size() : lowest(a) > lowest(b);
                        });
  const auto middle = [&](const std::vector<size_t>& cluster) {
    return sizes[cluster[cluster.size() / 2]];
  };
  std::vector<double> kept;
  for (const std::vector<size_t>& cluster : clusters)
    if (&cluster == &largest || middle(largest) <= 0 || middle(cluster) <= 0 ||
        nearestUnitRatio(middle(cluster) / middle(largest)) == 0)
      for (const size_t k : cluster) kept.push_back(sizes[k]);
  return kept;
}

/// How far landmarks lie from where those around them say.
class Neighbourhood {
 public:
  Neighbourhood(const std::vector<TrainingSet::Shape>& shapes, const Points& middle)
      : shapes_(shapes), middle_(middle), near_(VertexLocator(middle).neighbours(around)) {}

  const std::vector<int>& near(Eigen::Index j) const { return near_[static_cast<size_t>(j)]; }

  /// By the mean of their displacements: quick, and moved by one that strays.
  double fromMean(size_t k, Eigen::Index j) const {
    Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
    for (const int i : near(j)) mean += moved(k, i);
    return (moved(k, j) - mean / static_cast<double>(near(j).size())).norm();
  }

  /// By their median.
  double fromMedian(size_t k, Eigen::Index j) const {
    Eigen::RowVector3d median;
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> values;
      for (const int i : near(j)) values.push_back(moved(k, i)[axis]);
      median[axis] = medianOf(std::move(values));
    }
    return (moved(k, j) - median).norm();
  }

  /// Of fromMedian of those around it the second largest: next to the tip of a long beak they, too,
  /// lie far from where theirs say.
  double unrest(size_t k, Eigen::Index j) const {
    std::vector<double> values;
    for (const int i : near(j)) values.push_back(fromMedian(k, i));
    if (values.size() < 2) return 0;
    std::nth_element(values.begin(), values.end() - 2, values.end());
    return values[values.size() - 2];
  }

 private:
  Eigen::RowVector3d moved(size_t k, Eigen::Index j) const {
    return shapes_[k].landmarks.row(j) - middle_.row(j);
  }

  const std::vector<TrainingSet::Shape>& shapes_;
  const Points& middle_;
  std::vector<std::vector<int>> near_;
};

/// For each shape the landmarks that lie elsewhere than their neighbours say.
std::vector<Outlier> strayLandmarks(const std::vector<TrainingSet::Shape>& shapes,
                                    const Points& middle, double extent) {
  std::vector<Outlier> strays(shapes.size());
  if (middle.rows() < 2) return strays;
  std::vector<std::vector<std::pair<double, int>>> found(shapes.size());
  const Neighbourhood neighbourhood(shapes, middle);
  std::vector<double> away(shapes.size());
  for (Eigen::Index j = 0; j < middle.rows(); ++j) {
    for (size_t k = 0; k < shapes.size(); ++k) away[k] = neighbourhood.fromMean(k, j);
    const double usual = lowerQuantileOf(away, 0.75);
    const double most = std::max(farOfOne * usual, visibleOfOne * extent);
    for (size_t k = 0; k < shapes.size(); ++k) {
      if (away[k] <= most) continue;
      const double distance = neighbourhood.fromMedian(k, j);
      if (distance <= std::max(most, abrupt * neighbourhood.unrest(k, j))) continue;
      if (found[k].empty() || distance > strays[k].distance)
        strays[k] = {k, Outlier::Kind::Landmarks, usual > 0 ? distance / usual : 0, distance};
      found[k].emplace_back(-distance, static_cast<int>(j));
    }
  }
  for (size_t k = 0; k < shapes.size(); ++k) {
    std::sort(found[k].begin(), found[k].end());
    for (const auto& [distance, j] : found[k]) strays[k].landmarks.push_back(j);
  }
  return strays;
}

}  // namespace

std::vector<Outlier> findOutliers(const TrainingSet& given, const TrainingSet& aligned) {
  const size_t count = given.shapes().size();
  std::vector<Outlier> outliers;
  if (count < fewest) return outliers;

  std::vector<double> sizes, away;
  for (const TrainingSet::Shape& shape : given.shapes()) sizes.push_back(radius(shape.landmarks));
  const std::vector<double> group = inOneUnit(sizes);
  const double median = lowerQuantileOf(group, 0.5);
  const auto fromMedian = [median](double size) {
    return median > 0 && size > 0 ? std::fabs(std::log(size / median)) : 0;
  };
  for (const double size : group) away.push_back(fromMedian(size));
  const double usualSize = std::max(std::log(anotherSize), far * lowerQuantileOf(away, 0.75));

  const Points middle = medianShape(aligned.shapes());
  const double extent = radius(middle);
  std::vector<double> distances;
  for (const TrainingSet::Shape& shape : aligned.shapes())
    distances.push_back(distanceInSize(shape.landmarks, middle));
  const double usual = lowerQuantileOf(distances, 0.75), half = lowerQuantileOf(distances, 0.5);

  const std::vector<Outlier> strays = strayLandmarks(aligned.shapes(), middle, extent);
  for (size_t k = 0; k < count; ++k) {
    const double distance = distances[k];
    // A few that lie far off make a shape large, too, and move it.
    const std::vector<int>& lost = strays[k].landmarks;
    if (!lost.empty() && lost.size() <= fewStrays &&
        static_cast<Eigen::Index>(lost.size()) < middle.rows() &&
        fromMedian(radius(given.shapes()[k].landmarks, lost)) <= usualSize)
      outliers.push_back(strays[k]);
    else if (fromMedian(sizes[k]) > usualSize) {
      const double ratio = sizes[k] / median;
      outliers.push_back({k, Outlier::Kind::Size, ratio, distance, nearestUnitRatio(ratio)});
    } else if (distance > far * usual && distance > visible * extent) {
      outliers.push_back({k, Outlier::Kind::Shape, usual > 0 ? distance / usual : 0, distance});
    } else if (distance > twice * half && distance > unlike * extent) {
      outliers.push_back({k, Outlier::Kind::Shape, half > 0 ? distance / half : 0, distance});
    } else if (!strays[k].landmarks.empty()) {
      outliers.push_back(strays[k]);
    }
  }
  return outliers;
}

std::vector<int> repeatedShapes(const TrainingSet& aligned) {
  const std::vector<TrainingSet::Shape>& shapes = aligned.shapes();
  const double extent = radius(shapes.front().landmarks);
  // Equal shapes are equally far from any other one.
  std::vector<std::pair<double, size_t>> order;
  for (size_t k = 0; k < shapes.size(); ++k)
    order.emplace_back((shapes[k].landmarks - shapes.front().landmarks).norm(), k);
  std::sort(order.begin(), order.end());
  const double most = same * extent * std::sqrt(static_cast<double>(aligned.landmarkCount()));
  std::vector<int> first(shapes.size(), -1);
  for (size_t a = 0; a < order.size(); ++a)
    for (size_t b = a + 1; b < order.size() && order[b].first - order[a].first <= most; ++b) {
      const auto [one, other] = std::minmax(order[a].second, order[b].second);
      if ((shapes[one].landmarks - shapes[other].landmarks).norm() > most) continue;
      int& of = first[other];
      if (of < 0 || static_cast<size_t>(of) > one) of = static_cast<int>(one);
    }
  return first;
}

}  // namespace sphere_propagation
