// SPDX-License-Identifier: GPL-3.0-only
#include "filter_label_volume/itk_reader.h"

#include <NrrdIO.h>
#include <itkMetaImageIO.h>

#include <clocale>
#include <cstdlib>
#include <memory>
#include <regex>

#include "filter_label_volume/messages.h"

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

/// Headers have decimal points, whatever the user's language.
class DecimalPoints {
 public:
  DecimalPoints() : points_(newlocale(LC_NUMERIC_MASK, "C", locale_t{})) {
    if (points_ != locale_t{}) before_ = uselocale(points_);
  }
  ~DecimalPoints() {
    if (points_ == locale_t{}) return;
    uselocale(before_);
    freelocale(points_);
  }
  DecimalPoints(const DecimalPoints&) = delete;
  DecimalPoints& operator=(const DecimalPoints&) = delete;

 private:
  locale_t points_, before_{};
};

void requireAgreement(std::int64_t found, size_t bytesFound, std::int64_t numbers, size_t bytes) {
  if (bytesFound != bytes) refuse(volume_messages::noLabelType);
  if (found != numbers) refuse(volume_messages::itkDiffers, found, numbers);
}

}  // namespace

std::vector<char> readMetaWithItk(const std::string& fileName, std::int64_t numbers,
                                  size_t bytes) try {
  const Silence silence;
  const DecimalPoints decimalPoints;
  const auto io = itk::MetaImageIO::New();
  io->SetFileName(fileName);
  io->ReadImageInformation();
  const unsigned dimensions = io->GetNumberOfDimensions();
  std::int64_t found = io->GetNumberOfComponents();
  itk::ImageIORegion region(dimensions);
  for (unsigned axis = 0; axis < dimensions; ++axis) {
    region.SetSize(axis, io->GetDimensions(axis));
    found *= static_cast<std::int64_t>(io->GetDimensions(axis));
  }
  requireAgreement(found, io->GetComponentSize(), numbers, bytes);
  io->SetIORegion(region);
  std::vector<char> voxels(static_cast<size_t>(numbers) * bytes);
  io->Read(voxels.data());
  return voxels;
} catch (const itk::ExceptionObject& error) {
  // Its objects tell where they lie in memory, which is nobody's business and never the same.
  refuse(volume_messages::itkSays, std::regex_replace(std::string(error.GetDescription()),
                                                      std::regex("\\(0x[0-9a-f]+\\)"), ""));
}

/// By the library behind itk::NrrdImageIO, which reads all axes of the format; the class refuses
/// those of time.
std::vector<char> readNrrdWithItk(const std::string& fileName, std::int64_t numbers, size_t bytes) {
  const DecimalPoints decimalPoints;
  const std::unique_ptr<Nrrd, Nrrd* (*)(Nrrd*)> nrrd(nrrdNew(), &nrrdNuke);
  if (nrrdLoad(nrrd.get(), fileName.c_str(), nullptr) != 0) {
    const std::unique_ptr<char, void (*)(void*)> words(biffGetDone(NRRD), &std::free);
    refuse(volume_messages::itkSays, words ? words.get() : "");
  }
  requireAgreement(static_cast<std::int64_t>(nrrdElementNumber(nrrd.get())),
                   nrrdElementSize(nrrd.get()), numbers, bytes);
  const char* const begin = static_cast<const char*>(nrrd->data);
  return {begin, begin + static_cast<size_t>(numbers) * bytes};
}

}  // namespace sphere_propagation
