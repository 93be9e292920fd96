// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What several filters tell the user in the same words: log lines, returned figures.

#include <optional>
#include <string>
#include <vector>

#include "host/filter.h"
#include "vcg_ext/base/stopwatch.h"
#include "vcg_ext/base/text.h"
#include "vcg_ext/sphere/map_measures.h"

namespace sphere_propagation {

/// `"a", "b", "c" and 4 more`.
std::string namesIn(const std::vector<std::string>& names, size_t most = 10);

/// What layers say that have another number of something than most of them.
struct UnlikeCounts {
  std::string text;                 ///< `"a", "b" 1, "c" none, the others 2`
  std::vector<std::string> layers;  ///< those that are named
};

/// Nothing where all are the same; where no number is that of most layers, all are named. names,
/// counts: one per layer.
std::optional<UnlikeCounts> unlikeCounts(const std::vector<std::string>& names,
                                         const std::vector<int>& counts);

/// Of each lid the perimeter of a disc of its area. lids: number of the lid of each vertex, 0 on
/// none; may be empty.
std::vector<double> lidSizes(const Points& vertices, const Triangles& faces,
                             const std::vector<int>& lids);

/// How many of openings, or lids, of a surface tell it from others: small ones are defects. sizes:
/// of each surface those of its openings, by length.
std::vector<int> openingCounts(const std::vector<std::vector<double>>& sizes);

/// Warns by name of surfaces with other openings than the others.
void warnOfOpenings(const host::Task& task, const std::vector<std::string>& names,
                    const std::vector<std::vector<double>>& sizes);

/// What units a size that stands out is in, and what the others are in, as far as their ratio
/// tells: "cm" and "mm". units: as unit_ratio.h has them, not 0.
struct UnitNames {
  const char* its;
  const char* others;
};
UnitNames unitNames(double ratio, double units);

/// Several layers, or shapes, are of another size than the others, as one warning: of two halves
/// nobody can tell which is right, and the larger is named.
///
/// ratio: their size over that of the others; units: as unit_ratio.h has them, or 0.
struct SizeMessages {
  const host::Message &several, &half;
};
void warnOfManySizes(const host::Task& task, const std::vector<std::string>& names,
                     const std::vector<std::string>& others, double ratio, double units,
                     const SizeMessages& messages);

/// How many of several are named one by one; more are listed in one warning.
constexpr size_t maxNamedSingly = 3;

/// What is there more than once. firsts: for each the first that is the same, or -1.
struct RepetitionMessages {
  const host::Message &one, &several;
};
void warnOfRepetitions(const host::Task& task, const std::vector<std::string>& names,
                       const std::vector<int>& firsts, const RepetitionMessages& messages);

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
