// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Files that belong together by their numbers.

#include <string>
#include <vector>

namespace sphere_propagation {

/// Whether a character is one of 0 to 9.
bool isDigit(char c);

/// A file's name without its folder and its ending (.nii.gz counts as one).
std::string stemOf(const std::string& fileName);

/// The files beside this one whose names differ from it in one number only, ordered by that number,
/// itself among them. Of several numbers in the name it is the last one in which other files
/// differ. Just the file where there are no others. Throws VolumeError when two files have the same
/// number (as 1 and 01).
std::vector<std::string> fileSeries(const std::string& fileName);

}  // namespace sphere_propagation
