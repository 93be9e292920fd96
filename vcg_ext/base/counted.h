// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Numbers of things in texts for the user.

#include <string>

namespace sphere_propagation {

/// "1 edge", "12 edges".
inline std::string counted(long count, const std::string& noun, const std::string& plural) {
  return std::to_string(count) + " " + (count == 1 ? noun : plural);
}

}  // namespace sphere_propagation
