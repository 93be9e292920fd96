// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/export/npz_archive.h"

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

/// An .npy array of this type ("<f8", "<i4") and shape, without its values.
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
