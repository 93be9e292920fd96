// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Files that are written whole or not at all.

#include <filesystem>
#include <string>
#include <vector>

namespace sphere_propagation {

/// The ending of a file's name, ".npz", in small letters; empty where it has none.
std::string endingOf(const std::filesystem::path& path);

/// ".npz, .h5": for texts.
std::string listOf(const std::vector<std::string>& endings);

/// Whether the file can be written: one of these endings, in a folder that exists, no folder
/// itself. name: UTF-8. Throws ExportError.
void requireWritable(const std::string& name, const std::vector<std::string>& endings);

/// Writes beside the file and renames: what was there stays until the new file is complete. Throws
/// ExportError.
void writeWhole(const std::filesystem::path& path, const std::string& content);

}  // namespace sphere_propagation
