// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/fitting/fit_file.h"

#include <filesystem>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/model/export/npz_archive.h"
#include "vcg_ext/model/export/whole_file.h"

namespace sphere_propagation {

void requireFitFile(const std::string& path) { requireWritable(path, {".npz"}); }

void exportFit(const std::string& path, const FittingModel& model, const ModelFit& fit) {
  requireFitFile(path);
  const auto landmarks = fit.landmarks.rows(), modes = fit.scores.size();
  Eigen::MatrixXd covariance(3 * landmarks, 3);
  for (Eigen::Index j = 0; j < landmarks; ++j)
    covariance.middleRows<3>(3 * j) = fit.covariance[static_cast<size_t>(j)];
  NpzArchive archive;
  archive.add("landmarks", {landmarks, 3}, fit.landmarks);
  archive.add("sd", {landmarks}, fit.deviations());
  archive.add("covariance", {landmarks, 3, 3}, covariance);
  archive.add("scores", {modes}, fit.scores);
  archive.add("score_sd", {modes}, fit.scoreDeviations);
  archive.add("pose", {4, 4}, fit.pose());
  archive.add("noise", {}, Eigen::Matrix<double, 1, 1>(fit.noise));
  archive.add("surface_distance", {}, Eigen::Matrix<double, 1, 1>(fit.surfaceDistance));
  archive.addFaces("faces", model.faces());
  writeWhole(std::filesystem::u8path(path), std::move(archive).finished());
}

}  // namespace sphere_propagation
