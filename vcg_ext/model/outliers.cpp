// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/outliers.h"

#include <algorithm>
#include <cmath>

namespace sphere_propagation {
namespace {

constexpr size_t fewest = 5;                    // shapes that can tell which of them is apart
constexpr double far = 4, twice = 2;            // times the third quartile
constexpr double anotherSize = 1.8;             // factor
constexpr double visible = 0.02, unlike = 0.5;  // shares of the shape's size

double quantile(std::vector<double> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

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
    median.data()[i] = quantile(values, 0.5);
  }
  return median;
}

}  // namespace

std::vector<Outlier> findOutliers(const TrainingSet& given, const TrainingSet& aligned) {
  const size_t count = given.shapes().size();
  std::vector<Outlier> outliers;
  if (count < fewest) return outliers;

  std::vector<double> sizes, away;
  for (const TrainingSet::Shape& shape : given.shapes()) sizes.push_back(radius(shape.landmarks));
  const double median = quantile(sizes, 0.5);
  for (double& size : sizes) size = median > 0 && size > 0 ? size / median : 1;
  for (const double size : sizes) away.push_back(std::fabs(std::log(size)));
  const double usualSize = std::max(std::log(anotherSize), far * quantile(away, 0.75));

  const Points middle = medianShape(aligned.shapes());
  const double extent = radius(middle);
  std::vector<double> distances;
  for (const TrainingSet::Shape& shape : aligned.shapes())
    distances.push_back(distanceInSize(shape.landmarks, middle));
  const double usual = quantile(distances, 0.75);

  for (size_t k = 0; k < count; ++k) {
    const double distance = distances[k];
    if (away[k] > usualSize)
      outliers.push_back({k, Outlier::Kind::Size, sizes[k], distance});
    else if ((distance > far * usual && distance > visible * extent) ||
             (distance > twice * usual && distance > unlike * extent))
      outliers.push_back({k, Outlier::Kind::Shape, usual > 0 ? distance / usual : 0, distance});
  }
  return outliers;
}

}  // namespace sphere_propagation
