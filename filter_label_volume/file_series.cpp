// SPDX-License-Identifier: GPL-3.0-only
#include "filter_label_volume/file_series.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <utility>

#include "filter_label_volume/messages.h"

namespace sphere_propagation {
namespace {

namespace fs = std::filesystem;

std::string withoutZeros(const std::string& digits) {
  const size_t first = digits.find_first_not_of('0');
  return first == std::string::npos ? "0" : digits.substr(first);
}

bool isCompressed(const std::string& name) {
  constexpr size_t length = 3;
  return name.size() > length && name.compare(name.size() - length, length, ".gz") == 0;
}

/// "x.nii.gz" and "x.nii" say the same of a file.
std::string uncompressed(const std::string& name) {
  return isCompressed(name) ? name.substr(0, name.size() - 3) : name;
}

/// Digits in the order of the numbers that they write.
struct BySize {
  bool operator()(const std::string& a, const std::string& b) const {
    return a.size() != b.size() ? a.size() < b.size() : a < b;
  }
};

}  // namespace

bool isDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

std::string stemOf(const std::string& fileName) {
  const fs::path name = fs::u8path(fileName).filename();
  const fs::path stem = name.stem();
  return (name.extension() == ".gz" ? stem.stem() : stem).u8string();
}

std::vector<NamedFile> namedFiles(const std::string& text) {
  std::error_code ignored;
  const bool several = text.find_first_of("\n\t") != std::string::npos;
  if (!several || fs::exists(fs::u8path(text), ignored)) return {{text, stemOf(text)}};
  std::vector<NamedFile> files;
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at), path = line.substr(0, line.find('\t'));
    const std::string name =
        path.size() + 1 < line.size() ? line.substr(path.size() + 1) : stemOf(path);
    if (!path.empty()) files.push_back({path, name});
    at = end + 1;
  }
  return files;
}

std::vector<std::string> fileSeries(const std::string& fileName) {
  const fs::path path = fs::u8path(fileName);
  const std::string name = path.filename().u8string(), stem = stemOf(fileName);
  std::vector<std::string> names;
  std::error_code ignored;
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (entry.is_regular_file(ignored)) names.push_back(entry.path().filename().u8string());
  std::sort(names.begin(), names.end());

  for (size_t end = stem.size(); end > 0;) {
    if (!isDigit(stem[end - 1])) {
      --end;
      continue;
    }
    size_t begin = end;
    while (begin > 0 && isDigit(stem[begin - 1])) --begin;
    const std::string before = name.substr(0, begin), after = uncompressed(name).substr(end);
    std::map<std::string, std::string, BySize> found;
    for (const std::string& file : names) {
      const std::string other = uncompressed(file);
      if (other.size() <= before.size() + after.size() ||
          other.compare(0, before.size(), before) != 0 ||
          other.compare(other.size() - after.size(), after.size(), after) != 0)
        continue;
      const std::string digits =
          other.substr(before.size(), other.size() - before.size() - after.size());
      if (!std::all_of(digits.begin(), digits.end(), isDigit)) continue;
      const auto [at, isNew] = found.emplace(withoutZeros(digits), file);
      if (isNew) continue;
      if (uncompressed(at->second) != other)
        refuse(volume_messages::numberTwice, at->first, at->second, file);
      if (isCompressed(file) == isCompressed(name)) at->second = file;  // one file in two forms
    }
    if (found.size() > 1) {
      std::vector<std::string> series;
      series.reserve(found.size());
      for (const auto& file : found)
        series.push_back((path.parent_path() / fs::u8path(file.second)).u8string());
      return series;
    }
    end = begin;
  }
  return {fileName};
}

}  // namespace sphere_propagation
