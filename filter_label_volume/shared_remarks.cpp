// SPDX-License-Identifier: GPL-3.0-only
#include "filter_label_volume/shared_remarks.h"

#include <algorithm>
#include <cstdlib>

#include "filter_label_volume/file_series.h"

namespace sphere_propagation {
namespace {

constexpr size_t maxNames = 6;

bool isNumber(const std::string& text) {
  if (text.empty()) return false;
  char* end = nullptr;
  std::strtod(text.c_str(), &end);
  return *end == 0;
}

/// "12", or "12 to 25".
std::string rangeOf(const std::vector<std::string>& numbers) {
  const auto [least, most] = std::minmax_element(
      numbers.begin(), numbers.end(), [](const std::string& a, const std::string& b) {
        return std::strtod(a.c_str(), nullptr) < std::strtod(b.c_str(), nullptr);
      });
  return *least == *most ? *least : *least + " to " + *most;
}

/// Whether two texts are the same, or numbers both.
bool alike(const std::string& a, const std::string& b) {
  return a == b || (isNumber(a) && isNumber(b));
}

}  // namespace

void SharedRemarks::add(const std::string& layer, const host::Message& message,
                        const std::vector<std::string>& values) {
  for (Kind& kind : kinds_) {
    if (kind.message != &message) continue;
    bool same = true;
    for (size_t gap = 0; gap < values.size(); ++gap)
      same = same && alike(kind.values[gap].front(), values[gap]);
    if (!same) continue;
    for (size_t gap = 0; gap < values.size(); ++gap) kind.values[gap].push_back(values[gap]);
    kind.subjects.push_back(layer);
    kind.layers.push_back(layer);
    return;
  }
  Kind kind;
  kind.message = &message;
  for (const std::string& value : values) kind.values.push_back({value});
  kind.subjects.push_back(layer);
  kind.layers.push_back(layer);
  kinds_.push_back(std::move(kind));
}

void SharedRemarks::add(const std::string& subject, const host::Remark& remark,
                        const std::vector<std::string>& layers) {
  auto kind = std::find_if(kinds_.begin(), kinds_.end(), [&](const Kind& other) {
    return other.message == nullptr && other.remark.name == remark.name &&
           other.remark.text == remark.text;
  });
  if (kind == kinds_.end()) {
    kind = kinds_.insert(kind, Kind());
    kind->remark = remark;
  }
  kind->subjects.push_back(subject);
  kind->layers.insert(kind->layers.end(), layers.begin(), layers.end());
}

void SharedRemarks::tell(const host::Task& task) const {
  for (const Kind& kind : kinds_) {
    host::Remark remark = kind.remark;
    if (kind.message != nullptr) {
      std::vector<std::string> values;
      for (const auto& given : kind.values)
        values.push_back(isNumber(given.front()) ? rangeOf(given) : given.front());
      remark = {kind.message->kind, kind.message->name, "", filled(*kind.message, values), {}};
    }
    remark.subject = namesOf(kind.subjects);
    remark.layers = kind.layers;
    task.tell(remark);
  }
}

std::string namesOf(const std::vector<std::string>& layers) {
  if (layers.size() == 1) return layers.front();
  // Phases of one file differ in their number only.
  const auto stemLength = [](const std::string& name) {
    size_t length = name.size();
    while (length > 0 && isDigit(name[length - 1])) --length;
    return length;
  };
  const std::string stem = layers.front().substr(0, stemLength(layers.front()));
  const std::string ending = " phase ";
  const bool phases =
      stem.size() > ending.size() &&
      stem.compare(stem.size() - ending.size(), ending.size(), ending) == 0 &&
      std::all_of(layers.begin(), layers.end(), [&](const std::string& name) {
        return name.substr(0, stemLength(name)) == stem && name.size() > stem.size();
      });
  std::string text;
  if (!phases) {
    const size_t named = layers.size() > maxNames ? maxNames - 1 : layers.size();
    for (size_t i = 0; i < named; ++i) text += (i > 0 ? ", " : "") + layers[i];
    if (named < layers.size()) text += " and " + std::to_string(layers.size() - named) + " more";
    return text;
  }
  text = stem.substr(0, stem.size() - 1) + "s ";
  const auto digits = [&](size_t i) { return layers[i].substr(stem.size()); };
  for (size_t i = 0; i < layers.size();) {
    size_t end = i + 1;
    while (end < layers.size() && std::stol(digits(end)) == std::stol(digits(end - 1)) + 1) ++end;
    text += (i > 0 ? ", " : "") + digits(i);
    if (end - i > 1) text += (end - i > 2 ? " to " : ", ") + digits(end - 1);
    i = end;
  }
  return text;
}

}  // namespace sphere_propagation
