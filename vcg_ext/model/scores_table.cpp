// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/text.h"
#include "vcg_ext/model/model_formats.h"

namespace sphere_propagation {
namespace {

/// In quotation marks, those inside doubled: a label may hold commas and quotation marks.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
  return result + "\"";
}

}  // namespace

std::string scoresTable(const ShapeModel& model) {
  ExactText text;
  text << "shape";
  for (Eigen::Index m = 0; m < model.modeCount(); ++m) text << ",mode_" << m + 1;
  text << "\r\n";
  for (Eigen::Index k = 0; k < model.scores.rows(); ++k) {
    text << quoted(model.names[static_cast<size_t>(k)]);
    for (Eigen::Index m = 0; m < model.modeCount(); ++m) text << ',' << model.scores(k, m);
    text << "\r\n";
  }
  return text.str();
}

}  // namespace sphere_propagation
