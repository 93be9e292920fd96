// SPDX-License-Identifier: GPL-3.0-only
#include "filter_sphere_propagation/reporting.h"

#include <algorithm>

namespace sphere_propagation {

std::string namesIn(const std::vector<std::string>& names, size_t most) {
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), most); ++i)
    text += (i > 0 ? ", \"" : "\"") + names[i] + "\"";
  if (names.size() > most) text += " and " + std::to_string(names.size() - most) + " more";
  return text;
}

UnitNames unitNames(double ratio, double units) {
  // The larger numbers are those of the smaller unit.
  const char* small = units == 100 ? "cm" : "mm";
  const char* large = units == 10 ? "cm" : units == 25.4 ? "inches" : "m";
  return ratio > 1 ? UnitNames{small, large} : UnitNames{large, small};
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
