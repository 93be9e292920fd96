// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What the header of a volume file says: sizes, type, place in space; and whether the file can be
/// true to it. Place and units are computed here for every format, and nowhere else.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/message.h"
#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

enum class VolumeFormat { Nifti, Nrrd, Meta };

enum class VoxelType { Int8, Uint8, Int16, Uint16, Int32, Uint32, Int64, Uint64, Float, Double };

size_t bytesOf(VoxelType type);

struct VolumeHeader {
  VolumeFormat format = VolumeFormat::Nifti;
  std::array<std::int64_t, 4> size{1, 1, 1, 1};     ///< i, j, k, phases; each at least 1
  std::array<std::int64_t, 4> strides{0, 0, 0, 0};  ///< numbers from one to the next of each
  VoxelType type = VoxelType::Uint8;
  double slope = 1, shift = 0;  ///< a voxel stands for slope * number + shift
  Eigen::Matrix4d toRas =
      Eigen::Matrix4d::Identity();    ///< (i, j, k, 1) to mm, right-anterior-superior
  std::vector<host::Remark> remarks;  ///< what the user should know

  std::string voxelFile;         ///< NIfTI: where the voxels are
  std::int64_t voxelsBegin = 0;  ///< NIfTI: at which byte, when the file is unpacked
  bool swapped = false;          ///< NIfTI: their bytes are in the other order than this machine's

  std::int64_t voxels() const { return size[0] * size[1] * size[2] * size[3]; }
  bool isScaled() const { return slope != 1 || shift != 0; }
};

/// Reads the header of a NIfTI-1, NIfTI-2 or Analyze 7.5 (.nii, .hdr with .img, each also with
/// .gz), NRRD (.nrrd, .nhdr) or MetaImage (.mha, .mhd) file and compares it with what is there,
/// before memory is asked for: the data must be as long as the header says, or, where they are
/// compressed, be able to be. (ITK's readers believe the header.) Whether a NIfTI file is
/// compressed its bytes tell, not its name.
///
/// Place: NIfTI's is that of the sform, else of the qform, else of pixdim, as nibabel, FSL and
/// others have it. NRRD's is that of its space, whichever of the format's it is; spaces that name
/// no side of the patient, and files without one, are taken for left-posterior-superior, as ITK
/// has it. MetaImage's is that of TransformMatrix, Offset and ElementSpacing, which are
/// left-posterior-superior. Units are converted to mm in all of them.
///
/// Phases: the fourth axis, or a later one where those before it have one entry; in NRRD the axis
/// of the kind "time" or "list", or that has no direction in space, wherever it stands.
///
/// Throws VolumeError: no such file, none of these formats, two or more than four dimensions, no
/// slices, colours or vectors, truncated, a size that the file cannot hold or of more than 4 GB, a
/// place in space that is not finite.
VolumeHeader readVolumeHeader(const std::string& fileName);

/// The voxels in this machine's order of bytes. NIfTI is read here, NRRD and MetaImage by ITK.
/// Throws VolumeError when they are not all there.
std::vector<char> readVoxels(const std::string& fileName, const VolumeHeader& header);

}  // namespace sphere_propagation
