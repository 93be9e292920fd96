// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What the head of a volume file says, and whether the file can be true to it.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "filter_label_volume/itk_reader.h"
#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

struct VolumeHeader {
  VolumeFormat format = VolumeFormat::Nifti;
  std::vector<std::int64_t> size;  ///< 3 or 4 entries, each at least 1
  std::int64_t voxels = 0;         ///< their product
  bool phasesFirst =
      false;  ///< what ITK reads has the phase as the axis that changes fastest (NRRD's lists)
  std::optional<Eigen::Matrix4d>
      toRas;  ///< NIfTI: (i, j, k, 1) to mm, right-anterior-superior; else ITK tells
  /// NIfTI: ITK does not read it as it is: its axes are not at right angles, or lie in a plane, or
  /// are not as long as its pixdim says; or its voxels are real numbers, of which ITK takes NaN for
  /// 0; or the same name without ".gz" lies beside it, which ITK reads instead.
  bool unusual = false;
  std::int64_t voxelsBegin =
      0;  ///< NIfTI: byte at which the voxels begin, when the file is unpacked
  VoxelType type = VoxelType::Uint8;  ///< NIfTI: of the voxels
  double slope = 1,
         shift =
             0;  ///< NIfTI, where ITK does not read it: a voxel stands for slope * number + shift
  bool swapped = false;  ///< NIfTI: their bytes are in the other order than this machine's
  std::vector<std::string> notes;  ///< what the user should know
};

/// Reads the head of a NIfTI (.nii, .nii.gz), NRRD (.nrrd, .nhdr) or MetaImage (.mha, .mhd) file
/// and compares it with what is there, before memory is asked for: the data must be as long as the
/// head says, or, where they are compressed, be able to be. (ITK's readers believe the head.)
/// NIfTI's place in space is that of the sform, else of the qform, as nibabel, FSL and others have
/// it; ITK has other preferences and no shears.
///
/// Throws VolumeError: no such file, none of these formats, two or more than four dimensions, no
/// slices, colours or vectors, truncated, a size that the file cannot hold or of more than 4 GB, a
/// place in space that is not finite.
VolumeHeader readVolumeHeader(const std::string& fileName);

/// The voxels of an unusual NIfTI file, in this machine's order of bytes.
/// Throws VolumeError when they are not all there.
std::vector<char> readNiftiVoxels(const std::string& fileName, const VolumeHeader& header);

}  // namespace sphere_propagation
