// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What several filters tell the user in the same words: log lines, returned figures.

#include <string>
#include <vector>

#include "host/filter.h"
#include "vcg_ext/base/stopwatch.h"
#include "vcg_ext/base/text.h"
#include "vcg_ext/sphere/map_measures.h"

namespace sphere_propagation {

/// `"a", "b", "c" and 4 more`.
std::string namesIn(const std::vector<std::string>& names, size_t most = 10);

/// What units a size that stands out is in, and what the others are in, as far as their ratio
/// tells: "cm" and "mm". units: as unit_ratio.h has them, not 0.
struct UnitNames {
  const char* its;
  const char* others;
};
UnitNames unitNames(double ratio, double units);

/// How many of several are named one by one; more are listed in one warning.
constexpr size_t maxNamedSingly = 3;

/// "endo_03.ply: 12144 vertices, 0 flipped faces, area ratio sd 0.0021, angle error 9.2 degrees".
std::string describeMap(const std::string& label, const ClosedSurface& surface,
                        const MapMeasures& measures);

/// The figures of the maps of several layers, as they are returned: one entry per layer.
class MapFigures {
 public:
  explicit MapFigures(size_t layers);
  void set(size_t layer, const MapMeasures& measures, double seconds);
  void addTo(host::Outputs& outputs) const;

 private:
  Eigen::VectorXd flippedFaces_, areaRatioSd_, areaLogMean_, angleErrorMean_, seconds_;
};

}  // namespace sphere_propagation
