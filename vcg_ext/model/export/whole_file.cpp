// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/export/whole_file.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {

namespace fs = std::filesystem;

std::string endingOf(const fs::path& path) {
  std::string ending = path.extension().u8string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

std::string listOf(const std::vector<std::string>& endings) {
  std::string list;
  for (const std::string& ending : endings) list += (list.empty() ? "" : ", ") + ending;
  return list;
}

void requireWritable(const std::string& name, const std::vector<std::string>& endings) {
  const fs::path path = fs::u8path(name);
  const std::string ending = endingOf(path);
  const auto refuse = [&](Fault fault, std::string other = {}) {
    throw ExportError(
        Finding(fault, path.u8string()).against(std::move(other)).saying(listOf(endings)));
  };
  if (ending.empty()) refuse(Fault::NoFileEnding);
  if (std::find(endings.begin(), endings.end(), ending) == endings.end())
    refuse(Fault::UnknownFileFormat, ending);
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) refuse(Fault::FileIsFolder);
  const fs::path folder = path.parent_path();
  if (!folder.empty() && !fs::is_directory(folder, ignored))
    refuse(Fault::NoFolder, folder.u8string());
}

void writeWhole(const fs::path& path, const std::string& content) {
  fs::path part = path;
  part += ".part";
  errno = 0;
  std::ofstream file(part, std::ios::binary | std::ios::trunc);
  file.write(content.data(), static_cast<std::streamsize>(content.size()));
  file.close();
  std::error_code error(errno, std::generic_category());
  if (file.good()) {
    fs::rename(part, path, error);
    if (!error) return;
  }
  std::error_code ignored;
  fs::remove(part, ignored);
  throw ExportError(Finding(Fault::NotWritten, path.u8string())
                        .saying(error ? error.message() : std::string("writing failed")));
}

}  // namespace sphere_propagation
