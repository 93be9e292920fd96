// SPDX-License-Identifier: GPL-3.0-only
#include "filter_label_volume/volume_header.h"

#include <algorithm>
#include <fstream>
#include <initializer_list>

#include "filter_label_volume/header_checks.h"
#include "filter_label_volume/itk_reader.h"

namespace sphere_propagation {
namespace {

namespace fs = std::filesystem;

bool endsWith(const std::string& text, const std::string& ending) {
  return text.size() >= ending.size() &&
         text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

/// macOS keeps what other disks have no room for in files "._name": AppleDouble, RFC 1740.
bool isMacCompanion(const fs::path& path) {
  if (path.filename().u8string().rfind("._", 0) != 0) return false;
  char magic[4]{};
  std::ifstream(path, std::ios::binary).read(magic, 4);
  return std::string(magic, 4) == std::string("\x00\x05\x16\x07", 4);
}

}  // namespace

VolumeHeader readVolumeHeader(const std::string& fileName) {
  std::error_code error;
  const fs::path path = fs::u8path(fileName);
  if (!fs::exists(path, error)) refuse(volume_messages::noSuchFile);
  if (!fs::is_regular_file(path, error)) refuse(volume_messages::noFile);
  if (!std::ifstream(path)) refuse(volume_messages::notOpened);
  if (isMacCompanion(path))
    refuse(volume_messages::macCompanion, path.filename().u8string().substr(2));
  const std::string name = lowerCase(path.filename().u8string());
  const auto hasEnding = [&](std::initializer_list<const char*> endings) {
    return std::any_of(endings.begin(), endings.end(),
                       [&](const char* ending) { return endsWith(name, ending); });
  };
  VolumeHeader header;
  if (hasEnding({".nii", ".nii.gz", ".hdr", ".hdr.gz", ".img", ".img.gz"}))
    header = readNiftiHeader(fileName);
  else if (hasEnding({".nrrd", ".nhdr"}))
    header = readNrrdHeader(fileName);
  else if (hasEnding({".mha", ".mhd"}))
    header = readMetaHeader(fileName);
  else
    refuse(volume_messages::unknownEnding);
  if (!header.toRas.allFinite()) refuse(volume_messages::placeNotFinite);
  return header;
}

std::vector<char> readVoxels(const std::string& fileName, const VolumeHeader& header) {
  switch (header.format) {
    case VolumeFormat::Nrrd:
      return readNrrdWithItk(fileName, header.voxels(), bytesOf(header.type));
    case VolumeFormat::Meta:
      return readMetaWithItk(fileName, header.voxels(), bytesOf(header.type));
    case VolumeFormat::Nifti:
      break;
  }
  return readNiftiVoxels(header);
}

}  // namespace sphere_propagation
