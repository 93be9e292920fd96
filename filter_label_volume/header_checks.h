// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What the headers of all formats are checked for.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "filter_label_volume/messages.h"
#include "filter_label_volume/volume_header.h"

namespace sphere_propagation {

/// The readers behind readVolumeHeader: of .nii, .hdr, .img; of .nrrd, .nhdr; of .mha, .mhd.
VolumeHeader readNiftiHeader(const std::string& name);
VolumeHeader readNrrdHeader(const std::string& name);
VolumeHeader readMetaHeader(const std::string& name);
std::vector<char> readNiftiVoxels(const VolumeHeader& header);

/// "1.5 MB", "352 bytes".
std::string bytesInWords(double count);

/// Fills size and strides from a file's axes, the fastest first: three of space, and of the others
/// at most one with more than one entry, the phases. Throws VolumeError.
void setSize(VolumeHeader& header, const std::vector<std::int64_t>& axes);

/// The same where the axes of space are not the first three. spatial: three of them.
void setSize(VolumeHeader& header, const std::vector<std::int64_t>& axes,
             const std::vector<size_t>& spatial);

/// The data that the header claims against what the file holds, in bytes. Throws VolumeError where
/// the claim cannot be true.
void compareWithFile(VolumeHeader& header, double claimed, double present, bool compressed);

double sizeOfFile(const std::filesystem::path& path);

/// How much a unit is in mm, by its name ("mm", "um", "micron", "cm" ...); 0 where it is not known.
/// Nothing at all is mm.
double unitByName(std::string name);

std::string lowerCase(std::string text);
std::string trimmed(const std::string& text);

/// A header of lines "name<separator>value".
struct TextHeader {
  std::map<std::string, std::string> fields;  ///< by name in lower case
  std::map<std::string, std::string> pairs;   ///< NRRD's key:=value, by key in lower case
  double end = 0;  ///< where the data begin when they are in the same file

  std::string at(const std::string& name) const;
  /// The first of these names that the header has.
  std::string firstOf(const std::vector<std::string>& names) const;
  std::vector<std::int64_t> wholeNumbers(const std::string& name) const;
};

/// Lines until an empty one or until the name `last`.
TextHeader readTextHeader(const std::string& name, char separator, const std::string& last);

/// A number as headers write it, also "nan" and "inf", whatever the locale. Throws VolumeError
/// where the word is none.
double realNumber(const std::string& field, const std::string& word);
/// Those of a text, with blanks, commas or brackets between them.
std::vector<double> realNumbers(const std::string& field, const std::string& text);

/// dataFile: where the voxels are; empty: behind the header. text: numbers are written in digits.
void compareWithData(VolumeHeader& header, const TextHeader& head, const std::string& name,
                     const std::string& dataFile, bool compressed, bool text);

}  // namespace sphere_propagation
