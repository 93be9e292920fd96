// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Voxels of a file, as ITK reads them. The one header and source that meet ITK: it takes long to
/// compile, and brings an Eigen of its own, which must not meet this project's in one source.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace sphere_propagation {

enum class VolumeFormat { Nifti, Nrrd, Meta };

enum class VoxelType { Int8, Uint8, Int16, Uint16, Int32, Uint32, Int64, Uint64, Float, Double };

struct ItkVolume {
  std::int64_t numbers = 0;  ///< in the file: voxels times components
  unsigned components = 1;
  VoxelType type = VoxelType::Uint8;
  std::vector<char> voxels;
  std::array<double, 12>
      toLps{};  ///< rows of the 3 by 4 matrix from (i, j, k, 1) to mm, left-posterior-superior
};

/// Throws VolumeError with ITK's words, or when the voxels are of a type that is no label's, or
/// when there are not as many numbers as `expected`: memory is asked for after that only.
ItkVolume readWithItk(const std::string& fileName, VolumeFormat format, std::int64_t expected);

}  // namespace sphere_propagation
