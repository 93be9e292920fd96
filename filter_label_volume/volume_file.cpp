// SPDX-License-Identifier: GPL-3.0-only
#include "filter_label_volume/volume_file.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <locale>
#include <sstream>
#include <type_traits>
#include <utility>

#include "filter_label_volume/messages.h"
#include "filter_label_volume/volume_header.h"
#include "host/remedies.h"
#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

constexpr double wholeWithin = 1e-4;
constexpr double floatError = 1.2e-7;  // of slope and shift, relative

/// What labels can be; NaN is none, and counts as background.
enum class Voxel { Label, NotANumber, NoLabel };

template <class T>
Voxel labelOf(T value, std::int32_t& label) {
  if constexpr (std::is_floating_point_v<T>) {
    const auto real = static_cast<double>(value);
    if (std::isnan(real)) return Voxel::NotANumber;
    const double whole = std::nearbyint(real);
    if (!(std::fabs(real - whole) <= wholeWithin)) return Voxel::NoLabel;  // also where infinite
    label = std::fabs(whole) <= std::numeric_limits<std::int32_t>::max()
                ? static_cast<std::int32_t>(whole)
                : LabelGrid::beyond;
  } else {
    label = static_cast<std::int32_t>(static_cast<std::int64_t>(value));
    if (static_cast<T>(label) != value || (label < 0) != (value < T(0))) label = LabelGrid::beyond;
  }
  return Voxel::Label;
}

/// With six digits, or as many as tell it from a whole number.
std::string unlikeWhole(double value) {
  for (int digits = 6;; ++digits) {
    std::stringstream text;
    text.imbue(std::locale::classic());
    text.precision(digits);
    text << value;
    std::string shown = text.str();
    double read = 0;
    if (digits >= std::numeric_limits<double>::max_digits10 || !(text >> read) ||
        read != std::nearbyint(read))
      return shown;
  }
}

}  // namespace

struct VolumeFile::Content {
  std::string name;
  VolumeHeader header;
  Eigen::Matrix4d toWorld = Eigen::Matrix4d::Identity();
  std::vector<char> voxels;
  long notNumbers = 0;  // of the phases that were read

  template <class T>
  void copyPhase(int phase, LabelGrid& grid);
};

template <class T>
void VolumeFile::Content::copyPhase(int phase, LabelGrid& grid) {
  const T* const first = reinterpret_cast<const T*>(voxels.data()) + header.strides[3] * phase;
  const bool scaled = header.isScaled();
  long wrong = 0, nan = 0;
  Eigen::Vector3i firstWrong = Eigen::Vector3i::Zero();
  double wrongValue = 0;
  bool any = false;
  Eigen::Vector3i at;
  size_t to = 0;
  for (at[2] = 0; at[2] < grid.size[2]; ++at[2])
    for (at[1] = 0; at[1] < grid.size[1]; ++at[1]) {
      const T* from = first + header.strides[2] * at[2] + header.strides[1] * at[1];
      for (at[0] = 0; at[0] < grid.size[0]; ++at[0], from += header.strides[0], ++to) {
        std::int32_t& label = grid.values[to];
        Voxel found = Voxel::Label;
        double value = 0;
        if (scaled) {
          const double product = header.slope * static_cast<double>(*from);
          value = product + header.shift;
          const double whole = std::nearbyint(value);
          const double error = floatError * (std::fabs(product) + std::fabs(header.shift));
          found = labelOf(std::fabs(value - whole) <= wholeWithin + error ? whole : value, label);
        } else {
          found = labelOf(*from, label);
          if (found == Voxel::NoLabel) value = static_cast<double>(*from);
        }
        if (found == Voxel::Label) {
          any = any || label != 0;
          continue;
        }
        label = 0;
        if (found == Voxel::NotANumber)
          ++nan;
        else if (wrong++ == 0) {
          firstWrong = at;
          wrongValue = value;
        }
      }
    }
  if (wrong > 0)
    refuse(volume_messages::noLabels, wrong, firstWrong[0], firstWrong[1], firstWrong[2], phase,
           unlikeWhole(wrongValue));
  if (nan > 0 && !any) throw AbsentLabelError(host::said(volume_messages::onlyNan));
  notNumbers += nan;
}

VolumeFile::VolumeFile(std::string name, Coordinates coordinates)
    : content_(std::make_unique<Content>()) {
  content_->name = std::move(name);
  try {
    content_->header = readVolumeHeader(content_->name);
    content_->voxels = readVoxels(content_->name, content_->header);
    content_->toWorld = content_->header.toRas;
    LabelGrid place;  // one voxel: only its matrix is looked at
    place.size = Eigen::Vector3i::Ones();
    place.values = {0};
    place.toWorld = content_->toWorld;
    place.check();
  } catch (const Error& error) {
    const std::string why = host::sentence(error);
    refuse(volume_messages::notImported, content_->name, why.back() == '.' ? why : why + ".");
  }
  if (coordinates == Coordinates::Lps) content_->toWorld.topRows<2>() *= -1;
}

VolumeFile::~VolumeFile() = default;

int VolumeFile::phases() const { return static_cast<int>(content_->header.size[3]); }

std::vector<host::Remark> VolumeFile::remarks() const {
  std::vector<host::Remark> remarks = content_->header.remarks;
  if (content_->notNumbers > 0)
    remarks.push_back(host::remarkOn("", volume_messages::nanIsBackground, content_->notNumbers));
  return remarks;
}

LabelGrid VolumeFile::phase(int phase) const {
  LabelGrid grid;
  for (int axis = 0; axis < 3; ++axis)
    grid.size[axis] = static_cast<int>(content_->header.size[static_cast<size_t>(axis)]);
  grid.toWorld = content_->toWorld;
  grid.values.resize(grid.voxelCount());
  switch (content_->header.type) {
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
