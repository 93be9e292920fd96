// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Numbers in texts: for the user, and in files from which they are read back. All have a decimal
/// point, whatever the locale.

#include <sstream>
#include <string>

namespace sphere_propagation {

/// "1 edge", "12 edges".
std::string counted(long count, const std::string& noun, const std::string& plural);

/// With three significant digits: "0.0021", "12.3", "1.2e+06".
std::string shortNumber(double value);

/// A stream with 17 digits: each number can be read back exactly.
class ExactText : public std::ostringstream {
 public:
  ExactText();
};

}  // namespace sphere_propagation
