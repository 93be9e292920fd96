// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Numbers as text from which they can be read back exactly, in any locale.

#include <locale>
#include <sstream>
#include <string>

namespace sphere_propagation {

/// A stream with 17 digits and a decimal point.
class ExactText : public std::ostringstream {
 public:
  ExactText() {
    imbue(std::locale::classic());
    precision(17);
  }
};

}  // namespace sphere_propagation
