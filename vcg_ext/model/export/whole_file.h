// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Files that are written whole or not at all.

#include <filesystem>
#include <string>

namespace sphere_propagation {

/// Writes beside the file and renames: what was there stays until the new file is complete. Throws
/// ExportError.
void writeWhole(const std::filesystem::path& path, const std::string& content);

}  // namespace sphere_propagation
