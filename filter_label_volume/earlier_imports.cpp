// SPDX-License-Identifier: GPL-3.0-only
#include "filter_label_volume/earlier_imports.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "filter_label_volume/file_series.h"
#include "vcg_ext/base/fingerprint.h"

namespace sphere_propagation {
namespace {

namespace fs = std::filesystem;

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

}  // namespace

EarlierImports::EarlierImports(const host::Layers& layers, const std::vector<std::string>& files,
                               std::string labelText)
    : labelText_(std::move(labelText)) {
  for (const std::string& file : files) {
    stems_.insert(stemOf(file));
    fileMarks_.push_back(fingerprintOf(fullPath(file).u8string()));
  }
  if (files.size() > 1) series_ = fingerprintOf(seriesName(files));
  const std::set<int> marks(fileMarks_.begin(), fileMarks_.end());
  for (const host::Layer& layer : layers.all(host::LayerKind::Surface)) {
    Found found{layer, layer.plainLabel(), layer.mark(fileMark)};
    found.ofThisImport = (found.file && marks.count(*found.file) > 0) ||
                         (series_ && layer.mark(seriesMark) == series_);
    called_[found.label].push_back(surfaces_.size());
    surfaces_.push_back(std::move(found));
  }
  suffix_ = chooseSuffix(fullPath(files.front()).parent_path().filename().u8string());
}

std::string EarlierImports::chooseSuffix(const std::string& folder) const {
  // One more than there are layers that could be in the way.
  std::vector<std::string> candidates{"", " (" + folder + ")"};
  for (size_t number = 2; number <= surfaces_.size() + 1; ++number)
    candidates.push_back(" (" + folder + " " + std::to_string(number) + ")");
  std::map<std::string, size_t> number;
  for (size_t i = 0; i < candidates.size(); ++i) number.emplace(candidates[i], i);
  std::vector<bool> taken(candidates.size(), false);
  size_t before = candidates.size();  // what this import was called
  const auto beginsWith = [&](const Found& found, const std::string& stem,
                              const std::string& suffix) {
    const auto candidate = number.find(suffix);
    if (candidate == number.end() || stems_.count(stem) == 0) return;
    taken[candidate->second] = true;
    if (found.ofThisImport) before = std::min(before, candidate->second);
  };
  for (const Found& found : surfaces_) {
    if (!found.file) continue;
    // stem, suffix, " label ...": wherever these may part in the name.
    for (size_t end = found.label.find(" label "); end != std::string::npos;
         end = found.label.find(" label ", end + 1)) {
      const std::string head = found.label.substr(0, end);
      beginsWith(found, head, "");
      for (size_t at = head.find(" ("); at != std::string::npos; at = head.find(" (", at + 1))
        beginsWith(found, head.substr(0, at), head.substr(at));
    }
  }
  if (before < candidates.size()) return candidates[before];
  return candidates[static_cast<size_t>(std::find(taken.begin(), taken.end(), false) -
                                        taken.begin())];
}

void EarlierImports::place(host::NewLayer& layer, size_t file) {
  layer.marks[fileMark] = fileMarks_[file];
  if (series_) layer.marks[seriesMark] = *series_;
  const auto called = called_.find(layer.label);
  if (called == called_.end()) return;
  Found* replaced = nullptr;
  for (const size_t i : called->second) {
    Found& found = surfaces_[i];
    if (found.replaced || (found.file && *found.file != fileMarks_[file])) continue;
    if (replaced == nullptr || (found.file && !replaced->file)) replaced = &found;
  }
  if (replaced == nullptr) return;
  if (!replaced->file) ++replacedUnknown_;
  replaced->replaced = true;
  layer.replacedId = replaced->layer.id();
}

std::vector<host::Layer> EarlierImports::leftOver() const {
  std::vector<host::Layer> left;
  for (const Found& found : surfaces_) {
    if (found.replaced || !found.ofThisImport) continue;
    // Of these labels, and called as the import calls its layers: "... label 1" or "... label 1
    // phase 07".
    std::string label = found.label;
    const size_t phase = label.rfind(" phase ");
    if (phase != std::string::npos &&
        std::all_of(label.begin() + static_cast<long>(phase) + 7, label.end(), isDigit))
      label.resize(phase);
    if (label.size() > labelText_.size() &&
        label.compare(label.size() - labelText_.size(), labelText_.size(), labelText_) == 0)
      left.push_back(found.layer);
  }
  return left;
}

}  // namespace sphere_propagation
