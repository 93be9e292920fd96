// SPDX-License-Identifier: GPL-3.0-only
#include "filter_label_volume/itk_reader.h"

#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <limits>
#include <regex>
#include <type_traits>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

/// ITK prints warnings to the console otherwise.
class Silence {
 public:
  Silence() : before_(itk::Object::GetGlobalWarningDisplay()) {
    itk::Object::GlobalWarningDisplayOff();
  }
  ~Silence() { itk::Object::SetGlobalWarningDisplay(before_); }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  bool before_;
};

itk::ImageIOBase::Pointer readerFor(VolumeFormat format) {
  switch (format) {
    case VolumeFormat::Nifti:
      return itk::NiftiImageIO::New().GetPointer();
    case VolumeFormat::Nrrd:
      return itk::NrrdImageIO::New().GetPointer();
    case VolumeFormat::Meta:
      return itk::MetaImageIO::New().GetPointer();
  }
  return nullptr;
}

VoxelType typeOf(const itk::ImageIOBase& io) {
  using Type = itk::IOComponentEnum;
  const Type type = io.GetComponentType();
  if (type == Type::FLOAT) return VoxelType::Float;
  if (type == Type::DOUBLE) return VoxelType::Double;
  const bool isSigned = type == Type::CHAR || type == Type::SHORT || type == Type::INT ||
                        type == Type::LONG || type == Type::LONGLONG;
  if (isSigned || type == Type::UCHAR || type == Type::USHORT || type == Type::UINT ||
      type == Type::ULONG || type == Type::ULONGLONG) {
    switch (io.GetComponentSize()) {
      case 1:
        return isSigned ? VoxelType::Int8 : VoxelType::Uint8;
      case 2:
        return isSigned ? VoxelType::Int16 : VoxelType::Uint16;
      case 4:
        return isSigned ? VoxelType::Int32 : VoxelType::Uint32;
      case 8:
        return isSigned ? VoxelType::Int64 : VoxelType::Uint64;
      default:
        break;
    }
  }
  throw VolumeError("its voxels are of a type that is no label's");
}

}  // namespace

ItkVolume readWithItk(const std::string& fileName, VolumeFormat format, std::int64_t expected) try {
  const Silence silence;
  const itk::ImageIOBase::Pointer io = readerFor(format);
  io->SetFileName(fileName);
  io->ReadImageInformation();
  ItkVolume volume;
  const unsigned dimensions = io->GetNumberOfDimensions();
  volume.components = io->GetNumberOfComponents();
  volume.numbers = volume.components;
  itk::ImageIORegion region(dimensions);
  for (unsigned axis = 0; axis < dimensions; ++axis) {
    region.SetSize(axis, io->GetDimensions(axis));
    volume.numbers *= static_cast<std::int64_t>(io->GetDimensions(axis));
  }
  if (volume.numbers != expected)
    throw VolumeError("ITK finds " + std::to_string(volume.numbers) +
                      " numbers in it, its header says " + std::to_string(expected));
  volume.type = typeOf(*io);
  io->SetIORegion(region);
  volume.voxels.resize(static_cast<size_t>(expected) * io->GetComponentSize());
  io->Read(volume.voxels.data());
  for (unsigned axis = 0; axis < 3; ++axis) {
    volume.toLps[5 * axis] = 1;
    if (axis >= dimensions) continue;  // NIfTI of one slice: its matrix is known from the header
    const std::vector<double> direction = io->GetDirection(axis);
    for (unsigned row = 0; row < 3 && row < dimensions; ++row)
      volume.toLps[4 * row + axis] = direction.at(row) * io->GetSpacing(axis);
    volume.toLps[4 * axis + 3] = io->GetOrigin(axis);
  }
  return volume;
} catch (const itk::ExceptionObject& error) {
  // Its objects tell where they lie in memory, which is nobody's business and never the same.
  throw VolumeError("ITK says: " + std::regex_replace(error.GetDescription(),
                                                      std::regex("\\(0x[0-9a-f]+\\)"), ""));
}

}  // namespace sphere_propagation
