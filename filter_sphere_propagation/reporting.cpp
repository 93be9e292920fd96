// SPDX-License-Identifier: GPL-3.0-only
#include "filter_sphere_propagation/reporting.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "filter_sphere_propagation/messages.h"
#include "vcg_ext/base/statistics.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {

std::string namesIn(const std::vector<std::string>& names, size_t most) {
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), most); ++i)
    text += (i > 0 ? ", \"" : "\"") + names[i] + "\"";
  if (names.size() > most) text += " and " + std::to_string(names.size() - most) + " more";
  return text;
}

std::optional<UnlikeCounts> unlikeCounts(const std::vector<std::string>& names,
                                         const std::vector<int>& counts) {
  std::map<int, std::vector<std::string>> groups;
  for (size_t i = 0; i < names.size(); ++i) groups[counts[i]].push_back(names[i]);
  if (groups.size() < 2) return std::nullopt;
  UnlikeCounts unlike;
  const auto add = [&](const std::string& whose, int count) {
    unlike.text += (unlike.text.empty() ? "" : ", ") + whose + " " +
                   (count > 0 ? std::to_string(count) : std::string("none"));
  };
  std::optional<int> most;
  for (const auto& [count, group] : groups)
    if (2 * group.size() > names.size()) most = count;
  for (const auto& [count, group] : groups) {
    if (count == most) continue;
    add(namesIn(group), count);
    unlike.layers.insert(unlike.layers.end(), group.begin(), group.end());
  }
  if (most) add(groups[*most].size() > 1 ? "the others" : namesIn(groups[*most]), *most);
  return unlike;
}

std::vector<double> lidSizes(const Points& vertices, const Triangles& faces,
                             const std::vector<int>& lids) {
  std::map<int, double> areas;
  if (lids.empty()) return {};
  const Eigen::VectorXd ofFaces = faceAreas(vertices, faces);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    int lid = 0;  // faces beside the rim have corners on it
    for (int k = 0; k < 3; ++k) lid = std::max(lid, lids[static_cast<size_t>(faces(f, k))]);
    if (lid > 0) areas[lid] += ofFaces[f];
  }
  std::vector<double> sizes;
  for (const auto& [lid, area] : areas)
    sizes.push_back(std::sqrt(4 * static_cast<double>(EIGEN_PI) * area));
  return sizes;
}

std::vector<int> openingCounts(const std::vector<std::vector<double>>& sizes) {
  constexpr double small = 0.1;  // of the largest
  std::vector<double> largest;
  for (const std::vector<double>& of : sizes)
    if (!of.empty()) largest.push_back(*std::max_element(of.begin(), of.end()));
  const double least = small * medianOf(largest);
  std::vector<int> counts;
  for (const std::vector<double>& of : sizes)
    counts.push_back(static_cast<int>(
        std::count_if(of.begin(), of.end(), [&](double size) { return size >= least; })));
  return counts;
}

void warnOfOpenings(const host::Task& task, const std::vector<std::string>& names,
                    const std::vector<std::vector<double>>& sizes) {
  if (const auto unlike = unlikeCounts(names, openingCounts(sizes)))
    task.sayNaming(unlike->layers, messages::openingsDiffer, unlike->text);
}

UnitNames unitNames(double ratio, double units) {
  // The larger numbers are those of the smaller unit.
  const char* small = units == 100 ? "cm" : "mm";
  const char* large = units == 10 ? "cm" : units == 25.4 ? "inches" : "m";
  return ratio > 1 ? UnitNames{small, large} : UnitNames{large, small};
}

void warnOfManySizes(const host::Task& task, const std::vector<std::string>& names,
                     const std::vector<std::string>& others, double ratio, double units,
                     const SizeMessages& messages) {
  const size_t count = names.size() + others.size();
  const double factor = ratio > 1 ? ratio : 1 / ratio;
  const auto unitsOf = [&](double of, const char* beside) {
    if (units == 0) return std::string();
    const UnitNames unit = unitNames(of, units);
    return std::string(" (") + unit.its + beside + unit.others + "?)";
  };
  if (names.size() == others.size()) {
    const std::vector<std::string>& larger = ratio > 1 ? names : others;
    task.sayNaming(larger, messages.half, larger.size(), count, namesIn(larger), factor,
                   unitsOf(factor, " beside "));
    return;
  }
  task.sayNaming(names, messages.several, names.size(), count, namesIn(names), factor,
                 ratio > 1 ? "larger" : "smaller", unitsOf(ratio, " among "));
}

void warnOfRepetitions(const host::Task& task, const std::vector<std::string>& names,
                       const std::vector<int>& firsts, const RepetitionMessages& messages) {
  std::vector<std::string> copies, of;
  for (size_t i = 0; i < firsts.size(); ++i) {
    if (firsts[i] < 0) continue;
    copies.push_back(names[i]);
    of.push_back(names[static_cast<size_t>(firsts[i])]);
  }
  if (copies.size() > maxNamedSingly)
    task.sayNaming(copies, messages.several, copies.size(), names.size(), namesIn(copies),
                   copies.front(), of.front());
  else
    for (size_t k = 0; k < copies.size(); ++k) task.sayOf(copies[k], messages.one, of[k]);
}

std::string describeMap(const std::string& label, const ClosedSurface& surface,
                        const MapMeasures& measures) {
  return label + ": " + counted(surface.vertexCount(), "vertex", "vertices") + ", " +
         counted(measures.certificate.flippedFaces, "flipped face", "flipped faces") +
         ", area ratio sd " + shortNumber(measures.areaRatioSd) + ", angle error " +
         shortNumber(measures.angleErrorMean) + " degrees";
}

MapFigures::MapFigures(size_t layers) {
  for (Eigen::VectorXd* figure :
       {&flippedFaces_, &areaRatioSd_, &areaLogMean_, &angleErrorMean_, &seconds_})
    *figure = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(layers));
}

void MapFigures::set(size_t layer, const MapMeasures& measures, double seconds) {
  const auto i = static_cast<Eigen::Index>(layer);
  flippedFaces_[i] = static_cast<double>(measures.certificate.flippedFaces);
  areaRatioSd_[i] = measures.areaRatioSd;
  areaLogMean_[i] = measures.areaLogMean;
  angleErrorMean_[i] = measures.angleErrorMean;
  seconds_[i] = seconds;
}

void MapFigures::addTo(host::Outputs& outputs) const {
  outputs["flipped_faces"] = flippedFaces_;
  outputs["area_ratio_sd"] = areaRatioSd_;
  outputs["area_log_mean"] = areaLogMean_;
  outputs["angle_error_mean"] = angleErrorMean_;
  outputs["seconds"] = seconds_;
}

}  // namespace sphere_propagation
