// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/outliers.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "vcg_ext/base/statistics.h"
#include "vcg_ext/base/unit_ratio.h"

namespace sphere_propagation {
namespace {

constexpr size_t fewest = 5;                     // shapes that can tell which of them is apart
constexpr double far = 4, twice = 2;             // times the usual
constexpr double anotherSize = 1.8, groups = 3;  // factors
constexpr double visible = 0.02, unlike = 0.5;   // shares of the shape's size

double radius(const Points& points) {
  const Points centred = points.rowwise() - points.colwise().mean();
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

/// Of sizes in groups that differ as units do the largest group; all where there are none.
std::vector<double> largestGroup(const std::vector<double>& sizes) {
  const double first = sizes.front();
  std::vector<double> group = sizes;
  std::sort(group.begin(), group.end());
  for (;;) {
    size_t split = 0;
    double widest = groups;
    for (size_t i = 1; i < group.size(); ++i)
      if (group[i - 1] > 0 && group[i] >= widest * group[i - 1]) {
        widest = group[i] / group[i - 1];
        split = i;
      }
    if (split == 0) return group;
    const auto middle = group.begin() + static_cast<std::ptrdiff_t>(split);
    std::vector<double> below(group.begin(), middle), above(middle, group.end());
    if (nearestUnitRatio(medianOf(above) / medianOf(below)) == 0) return group;
    const bool lower =
        below.size() > above.size() || (below.size() == above.size() && first <= below.back());
    group = std::move(lower ? below : above);
  }
}

}  // namespace

std::vector<Outlier> findOutliers(const TrainingSet& given, const TrainingSet& aligned) {
  const size_t count = given.shapes().size();
  std::vector<Outlier> outliers;
  if (count < fewest) return outliers;

  std::vector<double> sizes, away;
  for (const TrainingSet::Shape& shape : given.shapes()) sizes.push_back(radius(shape.landmarks));
  const std::vector<double> group = largestGroup(sizes);
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

  for (size_t k = 0; k < count; ++k) {
    const double distance = distances[k];
    if (fromMedian(sizes[k]) > usualSize) {
      const double ratio = sizes[k] / median;
      outliers.push_back({k, Outlier::Kind::Size, ratio, distance, nearestUnitRatio(ratio)});
    } else if (distance > far * usual && distance > visible * extent) {
      outliers.push_back({k, Outlier::Kind::Shape, usual > 0 ? distance / usual : 0, distance});
    } else if (distance > twice * half && distance > unlike * extent) {
      outliers.push_back({k, Outlier::Kind::Shape, half > 0 ? distance / half : 0, distance});
    }
  }
  return outliers;
}

}  // namespace sphere_propagation
