// SPDX-License-Identifier: GPL-3.0-only
#include "filter_sphere_propagation/model_layers.h"

#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "filter_sphere_propagation/reporting.h"

namespace sphere_propagation {

std::string modeLabel(long mode, bool plus, double deviations) {
  return "mode " + std::to_string(mode) + (plus ? " +" : " -") + shortNumber(deviations) + " sd";
}

std::vector<GridCell> cellsOfModel(const std::vector<std::string>& labels) {
  struct End {
    bool isMean;
    long mode;
    bool plus;
  };
  std::vector<End> ends;
  std::map<long, double> rows;
  std::set<std::pair<long, bool>> taken;
  for (const std::string& label : labels) {
    End end{label.rfind(meanLabel, 0) == 0, 0, false};
    if (!end.isMean) {
      std::istringstream words(label);
      std::string word;
      char sign = '-';
      if (!(words >> word >> end.mode >> sign) || word != "mode") return {};
      end.plus = sign == '+';
    }
    if (!taken.insert({end.mode, end.plus}).second) return {};
    if (!end.isMean) rows[end.mode] = 0;
    ends.push_back(end);
  }
  double row = 0;
  for (auto& [mode, at] : rows) at = row++;
  const double before = taken.count({0, false}) > 0 ? 1 : 0;
  std::vector<GridCell> cells;
  for (const End& end : ends)
    cells.push_back(end.isMean ? GridCell{0, rows.empty() ? 0 : 0.5 * (row - 1)}
                               : GridCell{before + (end.plus ? 1 : 0), rows[end.mode]});
  return cells;
}

}  // namespace sphere_propagation
