// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/text.h"
#include "vcg_ext/model/little_endian.h"
#include "vcg_ext/model/model_formats.h"

namespace sphere_propagation {

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

  std::string bytes = header.str();
  for (Eigen::Index j = 0; j < model.mean.rows(); ++j) {
    for (int k = 0; k < 3; ++k) appendLittleEndian(bytes, model.mean(j, k));
    for (Eigen::Index m = 0; m < model.modeCount(); ++m)
      for (int k = 0; k < 3; ++k) appendLittleEndian(bytes, model.modes(3 * j + k, m));
  }
  for (Eigen::Index f = 0; f < model.faces.rows(); ++f) {
    appendLittleEndian(bytes, 3, 1);
    for (int k = 0; k < 3; ++k)
      appendLittleEndian(bytes, static_cast<std::uint32_t>(model.faces(f, k)), 4);
  }
  return bytes;
}

}  // namespace sphere_propagation
