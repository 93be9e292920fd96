// SPDX-License-Identifier: GPL-3.0-only
#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "vcg_ext/model/export/formats.h"
#include "vcg_ext/model/export/npz_archive.h"

namespace sphere_propagation {

std::string npzFile(const ShapeModel& model) {
  const Eigen::Index landmarks = model.mean.rows(), modes = model.modeCount();
  NpzArchive archive;
  archive.add("mean", {landmarks, 3}, model.mean);
  archive.add("modes", {modes, landmarks, 3}, model.modes.transpose());
  archive.add("eigenvalues", {modes}, model.eigenvalues);
  archive.add("scores", {model.scores.rows(), modes}, model.scores);
  archive.addFaces("faces", model.faces);
  std::vector<char> lid = model.leftOut;
  lid.resize(std::max(lid.size(), static_cast<std::size_t>(landmarks)), 0);
  archive.addMarks("lid", lid);
  if (!model.landmarkNames.empty()) {
    std::vector<std::string> names;
    std::vector<std::int64_t> numbers;
    for (const auto& [name, landmark] : model.landmarkNames) {
      names.push_back(name);
      numbers.push_back(landmark);
    }
    archive.addTexts("anchor_names", names);
    archive.addNumbers("anchor_landmarks", numbers);
  }
  return std::move(archive).finished();
}

}  // namespace sphere_propagation
