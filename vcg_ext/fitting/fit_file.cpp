// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/fitting/fit_file.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <system_error>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/model/export/npz_archive.h"
#include "vcg_ext/model/export/whole_file.h"

namespace sphere_propagation {

void requireFitFile(const std::string& name) {
  const std::filesystem::path path = std::filesystem::u8path(name);
  std::string ending = path.extension().u8string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto refuse = [&](Fault fault, std::string other = {}) {
    throw ExportError(Finding(fault, path.u8string()).against(std::move(other)).saying(".npz"));
  };
  if (ending.empty()) refuse(Fault::NoFileEnding);
  if (ending != ".npz") refuse(Fault::UnknownFileFormat, ending);
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) refuse(Fault::FileIsFolder);
  const std::filesystem::path folder = path.parent_path();
  if (!folder.empty() && !std::filesystem::is_directory(folder, ignored))
    refuse(Fault::NoFolder, folder.u8string());
}

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
