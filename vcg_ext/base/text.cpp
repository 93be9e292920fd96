// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/text.h"

#include <limits>
#include <locale>

namespace sphere_propagation {

std::string counted(long count, const std::string& noun, const std::string& plural) {
  return std::to_string(count) + " " + (count == 1 ? noun : plural);
}

std::string shortNumber(double value) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(3);
  text << value;
  return text.str();
}

ExactText::ExactText() {
  imbue(std::locale::classic());
  precision(std::numeric_limits<double>::max_digits10);
}

}  // namespace sphere_propagation
