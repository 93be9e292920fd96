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

/// A file that is to be imported, and what its layers are called.
struct NamedFile {
  std::string path, name;
};

/// What a parameter of files names: one file; or, where there is none of that name, several, one a
/// line. What follows a tab in a line is the name, else the file's (stemOf). Paths and names are
/// not empty.
std::vector<NamedFile> namedFiles(const std::string& text);

/// The files beside this one whose names differ from it in one number only, ordered by that number,
/// itself among them. Of several numbers in the name it is the last one in which other files
/// differ. Just the file where there are no others. Throws VolumeError when two files have the same
/// number (as 1 and 01).
std::vector<std::string> fileSeries(const std::string& fileName);

}  // namespace sphere_propagation
