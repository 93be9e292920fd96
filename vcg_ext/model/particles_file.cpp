// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/text.h"
#include "vcg_ext/model/model_formats.h"

namespace sphere_propagation {

std::string particlesFile(const Points& landmarks) {
  ExactText text;
  for (Eigen::Index j = 0; j < landmarks.rows(); ++j)
    text << landmarks(j, 0) << ' ' << landmarks(j, 1) << ' ' << landmarks(j, 2) << '\n';
  return text.str();
}

}  // namespace sphere_propagation
