// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/shape_model.h"

#include <algorithm>
#include <cmath>

#include "vcg_ext/model/thin_svd.h"

namespace sphere_propagation {
namespace {

using Vector = Eigen::VectorXd;

Eigen::Map<const Vector> asVector(const Points& points) { return {points.data(), points.size()}; }

Points asPoints(const Vector& vector) {
  return Eigen::Map<const Points>(vector.data(), vector.size() / 3, 3);
}

constexpr Eigen::Index worthThreads = 10'000'000;  // multiplications

/// -1 where the mode points away from its convention.
double signOf(const Eigen::Ref<const Vector>& mode) {
  const double largest = mode.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < mode.size(); ++i)
    if (std::fabs(mode[i]) >= (1 - 1e-6) * largest) return mode[i] < 0 ? -1 : 1;
  return 1;
}

}  // namespace

Points ShapeModel::shape(const Vector& b) const {
  return mean + asPoints(modes.leftCols(b.size()) * b);
}

Points ShapeModel::shape(Eigen::Index mode, double deviations) const {
  return mean + asPoints(modes.col(mode) * (deviations * std::sqrt(eigenvalues[mode])));
}

ShapeModel ShapeModel::truncated(Eigen::Index count) const {
  const Eigen::Index kept = std::min(count, modes.cols());
  return {mean,
          faces,
          modes.leftCols(kept),
          eigenvalues.head(kept),
          scores.leftCols(kept),
          totalVariance,
          names,
          leftOut,
          noiseVariance,
          landmarkNames};
}

ShapeModel buildShapeModel(const TrainingSet& set, double epsilon, Eigen::Index modes,
                           const Progress& progress) {
  const Eigen::Index shapes = set.shapeCount(), size = 3 * set.landmarkCount();
  ShapeModel model;
  model.faces = set.faces();
  model.leftOut = set.leftOut();
  model.mean = Points::Zero(set.landmarkCount(), 3);
  double longest = 0;
  for (const auto& [name, landmarks] : set.shapes()) {
    model.mean += landmarks / static_cast<double>(shapes);
    model.names.push_back(name);
    longest = std::max(longest, landmarks.norm());
  }
  Eigen::MatrixXd deviations(size, shapes);
  for (Eigen::Index k = 0; k < shapes; ++k)
    deviations.col(k) =
        asVector(set.shapes()[static_cast<size_t>(k)].landmarks) - asVector(model.mean);

  // Few coordinates are done before threads have started.
  ThreadPool pool(deviations.size() * std::min(shapes, size) < worthThreads ? 1 : 0);
  const double rounding = 8 * std::sqrt(static_cast<double>(shapes)) * epsilon * longest;
  ThinSvd svd = thinSvd(deviations, rounding, modes, pool, progress);
  const Eigen::Index count = std::min(shapes - 1, svd.s.size());
  model.modes = svd.u.leftCols(std::min(count, svd.u.cols()));
  model.eigenvalues = svd.s.head(count).cwiseAbs2() / static_cast<double>(shapes - 1);
  model.scores = svd.v.leftCols(count) * svd.s.head(count).asDiagonal();
  model.totalVariance = model.eigenvalues.sum();
  for (Eigen::Index m = 0; m < model.modes.cols(); ++m) {
    const double sign = signOf(model.modes.col(m));
    model.modes.col(m) *= sign;
    model.scores.col(m) *= sign;
  }
  return model;
}

}  // namespace sphere_propagation
