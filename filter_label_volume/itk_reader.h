// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Voxels of NRRD and MetaImage files: their encodings (raw, gzip, zlib, text, hex), detached data
/// files, skipped lines and orders of bytes are ITK's to decode. The one header and source that
/// meet ITK: it takes long to compile, and brings an Eigen of its own, which must not meet this
/// project's in one source.

#include <cstdint>
#include <string>
#include <vector>

namespace sphere_propagation {

/// numbers, bytes: how many numbers of how many bytes each the header says. Throws VolumeError with
/// ITK's words, or when ITK finds something else.
std::vector<char> readMetaWithItk(const std::string& fileName, std::int64_t numbers, size_t bytes);
std::vector<char> readNrrdWithItk(const std::string& fileName, std::int64_t numbers, size_t bytes);

}  // namespace sphere_propagation
