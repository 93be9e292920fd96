// SPDX-License-Identifier: GPL-3.0-only
// The formats without a container: ShapeWorks' particles, PLY, and a table of comma-separated
// values.

#include "vcg_ext/base/text.h"
#include "vcg_ext/model/export/bytes.h"
#include "vcg_ext/model/export/formats.h"

namespace sphere_propagation {
namespace {

/// In quotation marks, those inside doubled: a label may hold commas and quotation marks.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
  return result + "\"";
}

}  // namespace

std::string particlesFile(const Points& landmarks) {
  ExactText text;
  for (Eigen::Index j = 0; j < landmarks.rows(); ++j)
    text << landmarks(j, 0) << ' ' << landmarks(j, 1) << ' ' << landmarks(j, 2) << '\n';
  return text.str();
}

std::string plyFile(const ShapeModel& model) {
  ExactText header;
  header << "ply\nformat binary_little_endian 1.0\n"
         << "comment mean and modes of a statistical shape model: shape = mean + sum of score m "
            "times mode m\n";
  for (Eigen::Index m = 0; m < model.modeCount(); ++m)
    header << "comment eigenvalue " << m + 1 << ' ' << model.eigenvalues[m] << '\n';
  header << "element vertex " << model.mean.rows() << '\n';
  for (const char* axis : {"x", "y", "z"}) header << "property double " << axis << '\n';
  for (Eigen::Index m = 0; m < model.modeCount(); ++m)
    for (const char* axis : {"x", "y", "z"})
      header << "property double mode_" << m + 1 << '_' << axis << '\n';
  header << "element face " << model.faces.rows()
         << "\nproperty list uchar int vertex_indices\nend_header\n";

  Bytes bytes;
  bytes.put(header.str());
  for (Eigen::Index j = 0; j < model.mean.rows(); ++j) {
    for (int k = 0; k < 3; ++k) bytes.put(model.mean(j, k));
    for (Eigen::Index m = 0; m < model.modeCount(); ++m)
      for (int k = 0; k < 3; ++k) bytes.put(model.modes(3 * j + k, m));
  }
  for (Eigen::Index f = 0; f < model.faces.rows(); ++f) {
    bytes.put(3, 1);
    for (int k = 0; k < 3; ++k) bytes.put(static_cast<std::uint32_t>(model.faces(f, k)), 4);
  }
  return std::move(bytes).str();
}

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
