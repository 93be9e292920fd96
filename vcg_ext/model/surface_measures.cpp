// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/surface_measures.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/random.h"
#include "vcg_ext/base/rotation.h"
#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/model/leave_one_out.h"

namespace sphere_propagation {
namespace {

/// Points of a mesh, the k-th where k + 1/2 of `count` equal shares of the area lie before it; in
/// their faces at the places of a sequence of low discrepancy (M. Roberts' R2, 2018).
Points evenlySpread(const Points& vertices, const Triangles& faces, int count) {
  constexpr double first = 0.7548776662466927, second = 0.5698402909980532;
  const Eigen::VectorXd areas = faceAreas(vertices, faces);
  const double whole = areas.sum();
  Points points(count, 3);
  Eigen::Index face = 0;
  double before = 0;  // area of the faces that are passed
  for (int k = 0; k < count; ++k) {
    const double place = (k + 0.5) / count * whole;
    while (face + 1 < faces.rows() && before + areas[face] <= place) before += areas[face++];
    double u = 0.5 + first * k, v = 0.5 + second * k;
    u -= std::floor(u);
    v -= std::floor(v);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    points.row(k) = (1 - u - v) * vertices.row(faces(face, 0)) + u * vertices.row(faces(face, 1)) +
                    v * vertices.row(faces(face, 2));
  }
  return points;
}

double meanDistance(const Points& points, const SurfaceLocator& from, Eigen::Index every = 1) {
  double sum = 0;
  int near = -1, counted = 0;
  for (Eigen::Index i = 0; i < points.rows(); i += every, ++counted) {
    const SurfacePoint closest = from.closest(points.row(i).transpose(), near);
    near = closest.face;
    sum += closest.distance;
  }
  return sum / counted;
}

/// A surface in the frame of the model.
struct Compared {
  Compared(const Points& vertices, const Triangles& faces, int count)
      : points(evenlySpread(vertices, faces, count)), locator(vertices, faces) {}
  Points points;
  SurfaceLocator locator;
};

double distanceBetween(const Compared& a, const Compared& b) {
  return (meanDistance(a.points, b.locator) + meanDistance(b.points, a.locator)) / 2;
}

/// The vertices, moved as the landmarks `from` were when they became `to`: turned, shifted, scaled.
Points movedAlong(const Points& vertices, const Points& from, const Points& to) {
  const Eigen::RowVector3d centre = from.colwise().mean(), there = to.colwise().mean();
  const Points x = from.rowwise() - centre, y = to.rowwise() - there;
  const Eigen::Matrix3d rotation = bestRotation(y.transpose() * x);
  const double scale = std::sqrt(y.squaredNorm() / std::max(x.squaredNorm(), 1e-300));
  return (scale * (vertices.rowwise() - centre) * rotation.transpose()).rowwise() + there;
}

int foldedFaces(const Points& landmarks, const Triangles& faces, const Points& vertices,
                const Triangles& surface, const SurfaceLocator& locator) {
  const Points normals = faceNormals(landmarks, faces), under = faceNormals(vertices, surface);
  int folded = 0;
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const Vector3 centre =
        (landmarks.row(faces(f, 0)) + landmarks.row(faces(f, 1)) + landmarks.row(faces(f, 2))) / 3;
    const int below = locator.closest(centre).face;
    folded += normals.row(f).dot(under.row(below)) < 0;
  }
  return folded;
}

/// Mean and standard error of each row.
void summarise(const Eigen::MatrixXd& values, Eigen::VectorXd& mean, Eigen::VectorXd& error) {
  const auto count = static_cast<double>(values.cols());
  mean = values.rowwise().mean();
  error = (values.colwise() - mean).rowwise().squaredNorm() / (count * std::max(count - 1, 1.0));
  error = error.cwiseSqrt();
}

class Measurement {
 public:
  Measurement(const ShapeModel& model, const SurfaceMeasureParameters& parameters)
      : model_(model), parameters_(parameters), pool_(parameters.threads) {}

  void prepare(const TrainingSet& shapes, const TrainingSet& aligned,
               const std::vector<SampledSurface>& surfaces, SurfaceMeasures& measures) {
    const auto count = static_cast<int>(surfaces.size());
    surfaces_.resize(surfaces.size());
    measures.offSurface.resize(count);
    measures.foldedFaces.resize(count);
    pool_.forEach(count, [&](int i) {
      const auto k = static_cast<size_t>(i);
      const Points& landmarks = aligned.shapes()[k].landmarks;
      const Points vertices =
          movedAlong(surfaces[k].vertices, shapes.shapes()[k].landmarks, landmarks);
      surfaces_[k] = std::make_unique<Compared>(vertices, surfaces[k].faces, parameters_.points);
      measures.offSurface[i] = distanceFrom(*surfaces_[k], landmarks);
      measures.foldedFaces[i] =
          foldedFaces(landmarks, model_.faces, vertices, surfaces[k].faces, surfaces_[k]->locator);
    });
  }

  void generalisation(Eigen::Index modes, const Progress& progress, SurfaceMeasures& measures) {
    const auto count = static_cast<int>(surfaces_.size());
    const int left = std::min(count, parameters_.leftOut);
    Eigen::MatrixXd distances(modes, left);
    forEach(left, progress, [&](int i) {
      const auto k = static_cast<Eigen::Index>(static_cast<long>(i) * count / left);
      const Eigen::MatrixXd approximations = leftOutApproximations(model_.scores, k, modes);
      for (Eigen::Index m = 0; m < modes; ++m)
        distances(m, i) = distanceFrom(*surfaces_[static_cast<size_t>(k)],
                                       model_.shape(approximations.row(m).transpose()));
    });
    summarise(distances, measures.generalisation, measures.generalisationError);
  }

  void specificity(Eigen::Index modes, const Progress& progress, SurfaceMeasures& measures) {
    std::mt19937_64 bits(parameters_.seed);
    Eigen::MatrixXd scores(modes, parameters_.samples);
    for (Eigen::Index sample = 0; sample < scores.cols(); ++sample)
      for (Eigen::Index m = 0; m < modes; ++m)
        scores(m, sample) = normalNumbers(bits)[0] * std::sqrt(model_.eigenvalues[m]);
    Eigen::MatrixXd distances(modes, parameters_.samples);
    forEach(parameters_.samples, progress, [&](int sample) {
      for (Eigen::Index m = 0; m < modes; ++m)
        distances(m, sample) = nearest(model_.shape(scores.col(sample).head(m + 1)));
    });
    summarise(distances, measures.specificity, measures.specificityError);
  }

 private:
  template <class Work>
  void forEach(int count, const Progress& progress, const Work& work) {
    constexpr int together = 16;  // between two reports
    for (int begin = 0; begin < count; begin += together) {
      const int some = std::min(together, count - begin);
      pool_.forEach(some, [&](int i) { work(begin + i); });
      report(progress, static_cast<double>(begin + some) / count);
    }
  }

  double distanceFrom(const Compared& surface, const Points& landmarks) const {
    return distanceBetween(surface, Compared(landmarks, model_.faces, parameters_.points));
  }

  /// Of the shape's surface from the nearest training surface.
  double nearest(const Points& landmarks) const {
    constexpr size_t candidates = 3;
    constexpr Eigen::Index every = 8;  // of the points, to choose them by
    const Compared shape(landmarks, model_.faces, parameters_.points);
    std::vector<std::pair<double, size_t>> likely;
    for (size_t k = 0; k < surfaces_.size(); ++k)
      likely.emplace_back(meanDistance(shape.points, surfaces_[k]->locator, every), k);
    std::sort(likely.begin(), likely.end());
    double least = HUGE_VAL;
    for (size_t c = 0; c < std::min(candidates, likely.size()); ++c)
      least = std::min(least, distanceBetween(shape, *surfaces_[likely[c].second]));
    return least;
  }

  const ShapeModel& model_;
  const SurfaceMeasureParameters& parameters_;
  ThreadPool pool_;
  std::vector<std::unique_ptr<Compared>> surfaces_;
};

}  // namespace

SurfaceMeasures measureSurfaces(const ShapeModel& model, const TrainingSet& shapes,
                                const TrainingSet& aligned,
                                const std::vector<SampledSurface>& surfaces,
                                const SurfaceMeasureParameters& parameters,
                                const Progress& progress) {
  requireRange("number of modes", parameters.modes, Range::atLeast(0));
  requireRange("number of points", parameters.points, Range::atLeast(1));
  requireRange("number of samples for the specificity", parameters.samples,
               Range::between(1, SurfaceMeasureParameters::maxSamples));
  requireRange("number of shapes left out", parameters.leftOut, Range::atLeast(1));
  requireRange("number of threads", parameters.threads, Range::atLeast(0));
  if (static_cast<Eigen::Index>(surfaces.size()) != shapes.shapeCount())
    throw ArgumentError("There are " + std::to_string(surfaces.size()) + " surfaces for " +
                        std::to_string(shapes.shapeCount()) + " shapes.");
  const Eigen::Index modes = std::min<Eigen::Index>(parameters.modes, model.modeCount());
  SurfaceMeasures measures;
  Measurement measurement(model, parameters);
  measurement.prepare(shapes, aligned, surfaces, measures);
  report(progress, 0.1);
  measurement.generalisation(modes, part(progress, 0.1, 0.4), measures);
  measurement.specificity(modes, part(progress, 0.4, 1), measures);
  return measures;
}

}  // namespace sphere_propagation
