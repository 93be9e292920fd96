// SPDX-License-Identifier: GPL-3.0-only
#include "filter_label_volume/volume_file.h"

#include <cmath>
#include <cstdint>
#include <sstream>
#include <utility>

#include "filter_label_volume/itk_reader.h"
#include "filter_label_volume/volume_header.h"
#include "host/remedies.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/base/text.h"

namespace sphere_propagation {

struct VolumeFile::Content {
  std::string name;
  VolumeHeader header;
  Eigen::Matrix4d toWorld = Eigen::Matrix4d::Identity();
  VoxelType type = VoxelType::Uint8;
  std::vector<char> voxels;

  void read();
  template <class T>
  void copyPhase(int phase, LabelGrid& grid) const;
};

void VolumeFile::Content::read() {
  header = readVolumeHeader(name);
  if (header.unusual) {
    type = header.type;
    voxels = readNiftiVoxels(name, header);
    toWorld = *header.toRas;
    return;
  }
  ItkVolume volume = readWithItk(name, header.format, header.voxels);
  if (volume.components > 1 && !header.phasesFirst)
    throw VolumeError("it holds " + std::to_string(volume.components) +
                      " numbers per voxel: colours and vectors are no labels");
  type = volume.type;
  voxels = std::move(volume.voxels);
  if (header.toRas) {
    toWorld = *header.toRas;
    return;
  }
  toWorld.topRows<3>() =
      Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(volume.toLps.data());
  toWorld.topRows<2>() *= -1;
}

/// Labels of the type T, phase by phase or, where phases come first, with the phase running
/// fastest.
template <class T>
void VolumeFile::Content::copyPhase(int phase, LabelGrid& grid) const {
  const size_t count = grid.values.size(),
               phases = header.size.size() > 3 ? static_cast<size_t>(header.size[3]) : 1;
  const T* from =
      reinterpret_cast<const T*>(voxels.data()) +
      (header.phasesFirst ? static_cast<size_t>(phase) : count * static_cast<size_t>(phase));
  const size_t step = header.phasesFirst ? phases : 1;
  long wrong = 0;
  size_t first = 0;
  for (size_t i = 0; i < count; ++i) {
    const T value = from[i * step];
    bool good = true;
    if constexpr (std::is_floating_point_v<T>) {
      const double real = header.slope * static_cast<double>(value) + header.shift,
                   whole = std::nearbyint(real);
      good = std::fabs(real - whole) <= 1e-4 && std::fabs(whole) <= 2147483647.0;  // false for NaN
      if (good) grid.values[i] = static_cast<std::int32_t>(whole);
    } else {
      grid.values[i] = static_cast<std::int32_t>(static_cast<std::int64_t>(value));
      good = static_cast<T>(grid.values[i]) == value && (grid.values[i] < 0) == (value < T(0));
    }
    if (!good && wrong++ == 0) first = i;
  }
  if (wrong == 0) return;
  const auto nx = static_cast<size_t>(grid.size[0]), ny = static_cast<size_t>(grid.size[1]);
  std::ostringstream value;
  value << +from[first * step];
  throw VolumeError(
      "\"" + name + "\": " + counted(wrong, "voxel is no label", "voxels are no label") +
      ", first voxel (" + std::to_string(first % nx) + ", " + std::to_string(first / nx % ny) +
      ", " + std::to_string(first / nx / ny) + ") of phase " + std::to_string(phase) +
      ", which is " + value.str() +
      ": labels are whole numbers of 32 bits. Is this the image instead of its segmentation?");
}

VolumeFile::VolumeFile(std::string name, Coordinates coordinates)
    : content_(std::make_unique<Content>()) {
  content_->name = std::move(name);
  try {
    content_->read();
    LabelGrid place;  // one voxel: only its matrix is looked at
    place.size = Eigen::Vector3i::Ones();
    place.values = {0};
    place.toWorld = content_->toWorld;
    place.check();
  } catch (const Error& error) {
    const std::string why = host::sentence(error);
    throw VolumeError("\"" + content_->name + "\" cannot be imported: " + why +
                      (why.back() == '.' ? "" : "."));
  }
  if (coordinates == Coordinates::Lps) content_->toWorld.topRows<2>() *= -1;
}

VolumeFile::~VolumeFile() = default;

int VolumeFile::phases() const {
  return content_->header.size.size() > 3 ? static_cast<int>(content_->header.size[3]) : 1;
}

const std::vector<std::string>& VolumeFile::notes() const { return content_->header.notes; }

LabelGrid VolumeFile::phase(int phase) const {
  LabelGrid grid;
  for (int axis = 0; axis < 3; ++axis)
    grid.size[axis] = static_cast<int>(content_->header.size[static_cast<size_t>(axis)]);
  grid.toWorld = content_->toWorld;
  grid.values.resize(grid.voxelCount());
  switch (content_->type) {
    case VoxelType::Int8:
      content_->copyPhase<std::int8_t>(phase, grid);
      break;
    case VoxelType::Uint8:
      content_->copyPhase<std::uint8_t>(phase, grid);
      break;
    case VoxelType::Int16:
      content_->copyPhase<std::int16_t>(phase, grid);
      break;
    case VoxelType::Uint16:
      content_->copyPhase<std::uint16_t>(phase, grid);
      break;
    case VoxelType::Int32:
      content_->copyPhase<std::int32_t>(phase, grid);
      break;
    case VoxelType::Uint32:
      content_->copyPhase<std::uint32_t>(phase, grid);
      break;
    case VoxelType::Int64:
      content_->copyPhase<std::int64_t>(phase, grid);
      break;
    case VoxelType::Uint64:
      content_->copyPhase<std::uint64_t>(phase, grid);
      break;
    case VoxelType::Float:
      content_->copyPhase<float>(phase, grid);
      break;
    case VoxelType::Double:
      content_->copyPhase<double>(phase, grid);
      break;
  }
  return grid;
}

}  // namespace sphere_propagation
