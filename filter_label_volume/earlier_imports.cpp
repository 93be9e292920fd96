// SPDX-License-Identifier: GPL-3.0-only
#include "filter_label_volume/earlier_imports.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <utility>

#include "filter_label_volume/file_series.h"
#include "vcg_ext/base/fingerprint.h"

namespace sphere_propagation {
namespace {

namespace fs = std::filesystem;

bool isDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// The path that a file has whichever way it is named.
fs::path fullPath(const std::string& file) {
  std::error_code failure;
  const fs::path path = fs::u8path(file), full = fs::weakly_canonical(path, failure);
  return failure ? path : full;
}

int fingerprintOf(const std::string& text) {
  Fingerprint fingerprint;
  fingerprint.add(text);
  return fingerprint.short24();
}

/// What the names of a series have in common, without the number: which files there are does not
/// matter.
std::string seriesName(const std::vector<std::string>& files) {
  const std::string first = fullPath(files.front()).u8string(),
                    last = fullPath(files.back()).u8string();
  const size_t shorter = std::min(first.size(), last.size());
  size_t begin = 0, end = 0;
  while (begin < shorter && first[begin] == last[begin]) ++begin;
  while (begin > 0 && isDigit(first[begin - 1])) --begin;
  while (end < shorter - begin && first[first.size() - 1 - end] == last[last.size() - 1 - end])
    ++end;
  while (end > 0 && isDigit(first[first.size() - end])) --end;
  return first.substr(0, begin) + "#" + first.substr(first.size() - end);
}

bool contains(const std::vector<int>& numbers, int number) {
  return std::find(numbers.begin(), numbers.end(), number) != numbers.end();
}

}  // namespace

EarlierImports::EarlierImports(const host::Layers& layers, const std::vector<std::string>& files,
                               std::string labelText)
    : surfaces_(layers.all(host::LayerKind::Surface)), labelText_(std::move(labelText)) {
  for (const std::string& file : files) {
    stems_.push_back(stemOf(file));
    fileMarks_.push_back(fingerprintOf(fullPath(file).u8string()));
  }
  if (files.size() > 1) series_ = fingerprintOf(seriesName(files));
  suffix_ = chooseSuffix(fullPath(files.front()).parent_path().filename().u8string());
}

bool EarlierImports::ofThisImport(const host::Layer& layer) const {
  const std::optional<int> file = layer.mark(fileMark), series = layer.mark(seriesMark);
  return (file && contains(fileMarks_, *file)) || (series_ && series == series_);
}

bool EarlierImports::beginsWith(const host::Layer& layer, const std::string& suffix) const {
  const std::string label = layer.plainLabel();
  return std::any_of(stems_.begin(), stems_.end(), [&](const std::string& stem) {
    return label.rfind(stem + suffix + " label ", 0) == 0;
  });
}

std::string EarlierImports::chooseSuffix(const std::string& folder) const {
  std::vector<std::string> candidates{
      "", " (" + folder + ")"};  // one more than there are layers that could be in the way
  for (size_t number = 2; number <= surfaces_.size() + 1; ++number)
    candidates.push_back(" (" + folder + " " + std::to_string(number) + ")");
  std::vector<bool> taken(candidates.size(), false);
  for (size_t i = 0; i < candidates.size(); ++i)
    for (const host::Layer& layer : surfaces_) {
      if (!layer.mark(fileMark) || !beginsWith(layer, candidates[i])) continue;
      if (ofThisImport(layer)) return candidates[i];  // as it was called before
      taken[i] = true;
    }
  return candidates[static_cast<size_t>(std::find(taken.begin(), taken.end(), false) -
                                        taken.begin())];
}

void EarlierImports::place(host::NewLayer& layer, size_t file) {
  layer.marks[fileMark] = fileMarks_[file];
  if (series_) layer.marks[seriesMark] = *series_;
  const host::Layer* found = nullptr;
  for (const host::Layer& surface : surfaces_) {
    if (surface.plainLabel() != layer.label || contains(replaced_, surface.id())) continue;
    const std::optional<int> mark = surface.mark(fileMark);
    if (mark && *mark != fileMarks_[file]) continue;
    if (found == nullptr || (mark && !found->mark(fileMark))) found = &surface;
  }
  if (found == nullptr) return;
  if (!found->mark(fileMark)) ++replacedUnknown_;
  replaced_.push_back(found->id());
  layer.replacedId = found->id();
}

std::vector<host::Layer> EarlierImports::leftOver() const {
  std::vector<host::Layer> found;
  for (const host::Layer& layer : surfaces_) {
    if (contains(replaced_, layer.id()) || !ofThisImport(layer)) continue;
    // Of these labels, and called as the import calls its layers: "... label 1" or "... label 1
    // phase 07".
    std::string label = layer.plainLabel();
    const size_t phase = label.rfind(" phase ");
    if (phase != std::string::npos &&
        std::all_of(label.begin() + static_cast<long>(phase) + 7, label.end(), isDigit))
      label.resize(phase);
    if (label.size() > labelText_.size() &&
        label.compare(label.size() - labelText_.size(), labelText_.size(), labelText_) == 0)
      found.push_back(layer);
  }
  return found;
}

}  // namespace sphere_propagation
