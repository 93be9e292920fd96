// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Texts with named gaps for what varies: `{count|edge has|edges have} a face on one side only, the
/// first at face {first}`. A catalogue of such texts can be listed, and so documented, without
/// running what fills them.

#include <functional>
#include <string>
#include <string_view>

namespace sphere_propagation {

/// The text with its gaps filled. valueOf: the value of a gap by its name. A gap with two wordings
/// is a number and the first of them where the number is 1, else the second: "1 edge has", "3 edges
/// have". What stands in square brackets is left out where a gap in it is empty.
std::string fill(std::string_view text,
                 const std::function<std::string(std::string_view gap)>& valueOf);

/// So many digits, whole numbers in full: "0.123", "1.2e+60", "1000000".
std::string numeral(double value, int digits = 3);

}  // namespace sphere_propagation
