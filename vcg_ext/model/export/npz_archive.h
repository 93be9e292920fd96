// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// NumPy's archive of arrays (.npz): a zip without compression, per member a local header and its
/// bytes, at the end a directory (PKWARE's APPNOTE 6.3), of arrays of format 1.0 (NumPy Enhancement
/// Proposal 1). The same arrays, the same bytes.

#include <cstdint>
#include <string>
#include <vector>

#include "vcg_ext/base/matrices.h"
#include "vcg_ext/model/export/bytes.h"

namespace sphere_propagation {

class NpzArchive {
 public:
  using Shape = std::vector<Eigen::Index>;

  /// The entries of a matrix, row after row, as doubles. Throws ExportError, here and below, where
  /// the archive takes more than the 4 GB that such a zip can hold.
  template <class Matrix>
  void add(const std::string& name, const Shape& shape, const Matrix& rows) {
    requireRoom(8 * static_cast<std::size_t>(rows.size()));
    Bytes bytes = header("<f8", shape);
    bytes.reserve(bytes.size() + 8 * static_cast<std::size_t>(rows.size()));
    for (Eigen::Index r = 0; r < rows.rows(); ++r)
      for (Eigen::Index c = 0; c < rows.cols(); ++c) bytes.put(static_cast<double>(rows(r, c)));
    addMember(name, bytes.str());
  }
  void addFaces(const std::string& name, const Triangles& faces);
  void addMarks(const std::string& name, const std::vector<char>& marks);
  void addNumbers(const std::string& name, const std::vector<std::int64_t>& numbers);
  /// texts: UTF-8; what is none becomes U+FFFD.
  void addTexts(const std::string& name, const std::vector<std::string>& texts);

  std::string finished() &&;

 private:
  static Bytes header(const std::string& type, const Shape& shape);
  void requireRoom(std::size_t bytes) const;
  void addMember(const std::string& name, const std::string& content);

  Bytes bytes_, directory_;
  std::uint64_t members_ = 0;
};

}  // namespace sphere_propagation
