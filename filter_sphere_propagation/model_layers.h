// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The layers that a shape model makes: what they are called, and where they stand beside each
/// other.

#include <string>
#include <vector>

#include "vcg_ext/display/side_by_side.h"

namespace sphere_propagation {

constexpr const char* meanLabel = "mean shape";
/// "mode 1 -3 sd": `mode` counts from 1.
std::string modeLabel(long mode, bool plus, double deviations);

/// A row for each mode, minus before plus, the mean in front of them half way down. Empty, for the
/// grid that anything gets, where layers are called otherwise or two would share a cell, as those
/// of two models do.
std::vector<GridCell> cellsOfModel(const std::vector<std::string>& labels);

}  // namespace sphere_propagation
