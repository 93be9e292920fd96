// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/export/npz_archive.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

constexpr std::size_t maxZip =
    std::numeric_limits<std::uint32_t>::max() - 65536;  // leaves room for the headers

std::uint32_t crc32(const std::string& bytes) {
  static const std::array<std::uint32_t, 256> table = [] {
    std::array<std::uint32_t, 256> made{};
    for (std::uint32_t i = 0; i < made.size(); ++i) {
      std::uint32_t c = i;
      for (int bit = 0; bit < 8; ++bit) c = (c & 1) != 0 ? 0xedb88320u ^ (c >> 1) : c >> 1;
      made.at(i) = c;
    }
    return made;
  }();
  std::uint32_t crc = 0xffffffffu;
  for (const char byte : bytes)
    crc = table.at((crc ^ static_cast<unsigned char>(byte)) & 0xff) ^ (crc >> 8);
  return crc ^ 0xffffffffu;
}

constexpr std::uint32_t noCharacter = 0xFFFD;

/// The characters of a text in UTF-8.
std::vector<std::uint32_t> charactersOf(const std::string& text) {
  std::vector<std::uint32_t> characters;
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i++]);
    if (first < 0x80) {
      characters.push_back(first);
      continue;
    }
    const int more = first < 0xC2 ? 0 : first < 0xE0 ? 1 : first < 0xF0 ? 2 : first < 0xF5 ? 3 : 0;
    std::uint32_t character = first & (0x3FU >> static_cast<unsigned>(more));
    int read = 0;
    for (; read < more && i < text.size() && (text[i] & 0xC0) == 0x80; ++read)
      character = character << 6 | (static_cast<unsigned char>(text[i++]) & 0x3FU);
    characters.push_back(more > 0 && read == more ? character : noCharacter);
  }
  return characters;
}

}  // namespace

void NpzArchive::addFaces(const std::string& name, const Triangles& faces) {
  Bytes bytes = header("<i4", {faces.rows(), 3});
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) bytes.put(static_cast<std::uint32_t>(faces(f, k)), 4);
  addMember(name, bytes.str());
}

void NpzArchive::addMarks(const std::string& name, const std::vector<char>& marks) {
  Bytes bytes = header("|b1", {static_cast<Eigen::Index>(marks.size())});
  for (const char mark : marks) bytes.put(mark ? 1 : 0, 1);
  addMember(name, bytes.str());
}

void NpzArchive::addNumbers(const std::string& name, const std::vector<std::int64_t>& numbers) {
  Bytes bytes = header("<i8", {static_cast<Eigen::Index>(numbers.size())});
  for (const std::int64_t number : numbers) bytes.put(static_cast<std::uint64_t>(number), 8);
  addMember(name, bytes.str());
}

void NpzArchive::addTexts(const std::string& name, const std::vector<std::string>& texts) {
  std::vector<std::vector<std::uint32_t>> all;
  std::size_t longest = 1;
  for (const std::string& text : texts) {
    all.push_back(charactersOf(text));
    longest = std::max(longest, all.back().size());
  }
  Bytes bytes = header("<U" + std::to_string(longest), {static_cast<Eigen::Index>(texts.size())});
  for (std::vector<std::uint32_t>& characters : all) {
    characters.resize(longest, 0);
    for (const std::uint32_t character : characters) bytes.put(character, 4);
  }
  addMember(name, bytes.str());
}

std::string NpzArchive::finished() && {
  const std::size_t start = bytes_.size();
  bytes_.put(directory_.str());
  bytes_.put(0x06054b50, 4);
  bytes_.put(0, 4);  // disks
  bytes_.put(members_, 2).put(members_, 2);
  bytes_.put(directory_.size(), 4).put(start, 4);
  bytes_.put(0, 2);  // comment
  return std::move(bytes_).str();
}

/// An .npy array of this type ("<f8", "<i4", "<U5") and shape, without its values.
Bytes NpzArchive::header(const std::string& type, const Shape& shape) {
  std::string dictionary = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (";
  for (const Eigen::Index extent : shape) dictionary += std::to_string(extent) + ", ";
  dictionary += "), }";
  const std::size_t before = 10;  // magic, version, length
  while ((before + dictionary.size() + 1) % 64 != 0) dictionary += ' ';
  dictionary += '\n';
  Bytes bytes;
  bytes.put("\x93NUMPY").put(1, 1).put(0, 1).put(dictionary.size(), 2).put(dictionary);
  return bytes;
}

void NpzArchive::requireRoom(std::size_t bytes) const {
  if (bytes > maxZip || bytes_.size() > maxZip - bytes)
    throw ExportError(Finding(Fault::FileTooLarge).saying(".npz"));
}

void NpzArchive::addMember(const std::string& array, const std::string& content) {
  requireRoom(content.size());
  const std::string name = array + ".npy";
  Bytes common;           // what local header and directory have in common
  common.put(20, 2);      // version that can read it
  common.put(0, 2);       // flags
  common.put(0, 2);       // stored
  common.put(0, 2);       // midnight
  common.put(0x0021, 2);  // 1 January 1980: the same model, the same file
  common.put(crc32(content), 4);
  common.put(content.size(), 4).put(content.size(), 4);
  common.put(name.size(), 2);
  common.put(0, 2);  // extra field
  directory_.put(0x02014b50, 4).put(20, 2).put(common.str());
  directory_.put(0, 2);  // comment
  directory_.put(0, 2);  // disk
  directory_.put(0, 2);  // internal attributes
  directory_.put(0, 4);  // external attributes
  directory_.put(bytes_.size(), 4).put(name);
  bytes_.put(0x04034b50, 4).put(common.str()).put(name).put(content);
  ++members_;
}

}  // namespace sphere_propagation
