// SPDX-License-Identifier: GPL-3.0-only
// A zip without compression: per member a local header and its bytes, at the end a directory
// (PKWARE's APPNOTE 6.3).

#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "vcg_ext/base/error.h"
#include "vcg_ext/model/little_endian.h"
#include "vcg_ext/model/model_formats.h"

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

class Zip {
 public:
  void add(const std::string& name, const std::string& content) {
    if (bytes_.size() + content.size() > maxZip)
      throw ExportError("The model is too large for a .npz file (4 GB). Keep fewer modes.");
    std::string common;                     // what local header and directory have in common
    appendLittleEndian(common, 20, 2);      // version that can read it
    appendLittleEndian(common, 0, 2);       // flags
    appendLittleEndian(common, 0, 2);       // stored
    appendLittleEndian(common, 0, 2);       // midnight
    appendLittleEndian(common, 0x0021, 2);  // 1 January 1980: the same model, the same file
    appendLittleEndian(common, crc32(content), 4);
    appendLittleEndian(common, content.size(), 4);
    appendLittleEndian(common, content.size(), 4);
    appendLittleEndian(common, name.size(), 2);
    appendLittleEndian(common, 0, 2);  // extra field
    appendLittleEndian(directory_, 0x02014b50, 4);
    appendLittleEndian(directory_, 20, 2);
    directory_ += common;
    appendLittleEndian(directory_, 0, 2);  // comment
    appendLittleEndian(directory_, 0, 2);  // disk
    appendLittleEndian(directory_, 0, 2);  // internal attributes
    appendLittleEndian(directory_, 0, 4);  // external attributes
    appendLittleEndian(directory_, bytes_.size(), 4);
    directory_ += name;
    appendLittleEndian(bytes_, 0x04034b50, 4);
    bytes_ += common + name;
    bytes_ += content;
    ++members_;
  }

  std::string finished() && {
    const std::size_t start = bytes_.size();
    bytes_ += directory_;
    appendLittleEndian(bytes_, 0x06054b50, 4);
    appendLittleEndian(bytes_, 0, 4);  // disks
    appendLittleEndian(bytes_, members_, 2);
    appendLittleEndian(bytes_, members_, 2);
    appendLittleEndian(bytes_, directory_.size(), 4);
    appendLittleEndian(bytes_, start, 4);
    appendLittleEndian(bytes_, 0, 2);  // comment
    return std::move(bytes_);
  }

 private:
  std::string bytes_, directory_;
  std::uint64_t members_ = 0;
};

/// An .npy array of this type ("<f8", "<i4") and shape, without its values.
std::string npyHeader(const std::string& type, const std::vector<Eigen::Index>& shape) {
  std::string dictionary = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (";
  for (const Eigen::Index extent : shape) dictionary += std::to_string(extent) + ", ";
  dictionary += "), }";
  const std::size_t before = 10;  // magic, version, length
  while ((before + dictionary.size() + 1) % 64 != 0) dictionary += ' ';
  dictionary += '\n';
  std::string header = "\x93NUMPY";
  header += '\x01';
  header += '\0';
  appendLittleEndian(header, dictionary.size(), 2);
  return header + dictionary;
}

template <class Matrix>
std::string doubles(const std::vector<Eigen::Index>& shape, const Matrix& rows) {
  if (static_cast<std::size_t>(rows.size()) > maxZip / 8)
    throw ExportError("The model is too large for a .npz file (4 GB). Keep fewer modes.");
  std::string bytes = npyHeader("<f8", shape);
  bytes.reserve(bytes.size() + 8 * static_cast<std::size_t>(rows.size()));
  for (Eigen::Index r = 0; r < rows.rows(); ++r)
    for (Eigen::Index c = 0; c < rows.cols(); ++c) appendLittleEndian(bytes, rows(r, c));
  return bytes;
}

}  // namespace

std::string npzFile(const ShapeModel& model) {
  const Eigen::Index landmarks = model.mean.rows(), modes = model.modeCount();
  std::string faces = npyHeader("<i4", {model.faces.rows(), 3});
  for (Eigen::Index f = 0; f < model.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      appendLittleEndian(faces, static_cast<std::uint32_t>(model.faces(f, k)), 4);
  Zip zip;
  zip.add("mean.npy", doubles({landmarks, 3}, model.mean));
  zip.add("modes.npy", doubles({modes, landmarks, 3}, model.modes.transpose()));
  zip.add("eigenvalues.npy", doubles({modes}, model.eigenvalues));
  zip.add("scores.npy", doubles({model.scores.rows(), modes}, model.scores));
  zip.add("faces.npy", faces);
  return std::move(zip).finished();
}

}  // namespace sphere_propagation
