// SPDX-License-Identifier: GPL-3.0-only
// A zip without compression: per member a local header and its bytes, at the end a directory
// (PKWARE's APPNOTE 6.3).

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "vcg_ext/base/error.h"
#include "vcg_ext/model/export/bytes.h"
#include "vcg_ext/model/export/formats.h"

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
      throw ExportError(Finding(Fault::FileTooLarge).saying(".npz"));
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

  std::string finished() && {
    const std::size_t start = bytes_.size();
    bytes_.put(directory_.str());
    bytes_.put(0x06054b50, 4);
    bytes_.put(0, 4);  // disks
    bytes_.put(members_, 2).put(members_, 2);
    bytes_.put(directory_.size(), 4).put(start, 4);
    bytes_.put(0, 2);  // comment
    return std::move(bytes_).str();
  }

 private:
  Bytes bytes_, directory_;
  std::uint64_t members_ = 0;
};

/// An .npy array of this type ("<f8", "<i4") and shape, without its values.
Bytes npyHeader(const std::string& type, const std::vector<Eigen::Index>& shape) {
  std::string dictionary = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (";
  for (const Eigen::Index extent : shape) dictionary += std::to_string(extent) + ", ";
  dictionary += "), }";
  const std::size_t before = 10;  // magic, version, length
  while ((before + dictionary.size() + 1) % 64 != 0) dictionary += ' ';
  dictionary += '\n';
  Bytes header;
  header.put("\x93NUMPY").put(1, 1).put(0, 1).put(dictionary.size(), 2).put(dictionary);
  return header;
}

template <class Matrix>
std::string doubles(const std::vector<Eigen::Index>& shape, const Matrix& rows) {
  if (static_cast<std::size_t>(rows.size()) > maxZip / 8)
    throw ExportError(Finding(Fault::FileTooLarge).saying(".npz"));
  Bytes bytes = npyHeader("<f8", shape);
  bytes.reserve(bytes.size() + 8 * static_cast<std::size_t>(rows.size()));
  for (Eigen::Index r = 0; r < rows.rows(); ++r)
    for (Eigen::Index c = 0; c < rows.cols(); ++c) bytes.put(rows(r, c));
  return std::move(bytes).str();
}

}  // namespace

std::string npzFile(const ShapeModel& model) {
  const Eigen::Index landmarks = model.mean.rows(), modes = model.modeCount();
  Bytes faces = npyHeader("<i4", {model.faces.rows(), 3});
  for (Eigen::Index f = 0; f < model.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) faces.put(static_cast<std::uint32_t>(model.faces(f, k)), 4);
  Zip zip;
  zip.add("mean.npy", doubles({landmarks, 3}, model.mean));
  zip.add("modes.npy", doubles({modes, landmarks, 3}, model.modes.transpose()));
  zip.add("eigenvalues.npy", doubles({modes}, model.eigenvalues));
  zip.add("scores.npy", doubles({model.scores.rows(), modes}, model.scores));
  zip.add("faces.npy", faces.str());
  std::vector<char> lid = model.leftOut;
  lid.resize(std::max(lid.size(), static_cast<std::size_t>(landmarks)), 0);
  Bytes marks = npyHeader("|b1", {static_cast<Eigen::Index>(lid.size())});
  for (const char mark : lid) marks.put(mark ? 1 : 0, 1);
  zip.add("lid.npy", marks.str());
  return std::move(zip).finished();
}

}  // namespace sphere_propagation
