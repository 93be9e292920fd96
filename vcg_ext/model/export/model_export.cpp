// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/export/model_export.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include "vcg_ext/model/export/formats.h"
#include "vcg_ext/model/export/whole_file.h"

namespace sphere_propagation {
namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 6> endings = {".npz",       ".h5",  ".json",
                                                ".particles", ".ply", ".csv"};

}  // namespace

std::string modelFileEndings() { return listOf({endings.begin(), endings.end()}); }

void requireExportable(const std::string& name) {
  requireWritable(name, {endings.begin(), endings.end()});
}

std::vector<std::string> exportModel(const std::string& name, const ShapeModel& model,
                                     const TrainingSet& aligned) {
  requireExportable(name);
  const fs::path path = fs::u8path(name);
  const std::string ending = endingOf(path);
  if (ending == ".npz") writeWhole(path, npzFile(model));
  if (ending == ".h5") writeWhole(path, statismoFile(model));
  if (ending == ".json") writeWhole(path, statismoJson(model));
  if (ending == ".ply") writeWhole(path, plyFile(model));
  if (ending == ".csv") writeWhole(path, scoresTable(model));
  std::vector<std::string> written = {name};
  if (ending != ".particles") return written;
  const size_t digits = std::max<size_t>(3, std::to_string(aligned.shapes().size() - 1).size());
  for (size_t k = 0; k < aligned.shapes().size(); ++k) {
    std::string number = std::to_string(k);
    number.insert(0, digits - number.size(), '0');
    fs::path beside = path;
    beside.replace_filename(path.stem().u8string() + "_" + number + path.extension().u8string());
    writeWhole(beside, particlesFile(aligned.shapes()[k].landmarks));
    written.push_back(beside.u8string());
  }
  writeWhole(path, particlesFile(model.mean));
  return written;
}

}  // namespace sphere_propagation
