// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Label volumes in files.

#include <memory>
#include <string>
#include <vector>

#include "host/message.h"
#include "vcg_ext/volume/label_grid.h"

namespace sphere_propagation {

/// The coordinates that surfaces get: x to the right and y to the front of the patient, or the
/// other way.
enum class Coordinates { Ras, Lps };

/// A file of one or more phases, read when it is made; its voxels stay in the type that they have
/// in the file.
class VolumeFile {
 public:
  /// Throws VolumeError, which names the file, says what is wrong with it and what to do.
  explicit VolumeFile(std::string name, Coordinates coordinates = Coordinates::Ras);
  ~VolumeFile();
  VolumeFile(const VolumeFile&) = delete;
  VolumeFile& operator=(const VolumeFile&) = delete;

  int phases() const;
  /// phase: 0 to phases() - 1. NaN is background. Labels beyond 32 bits become
  /// LabelGrid::beyond. Throws VolumeError when a voxel is no whole number; AbsentLabelError when
  /// all are NaN or 0.
  LabelGrid phase(int phase) const;
  /// What the user should know about the file, and the phases that were read so far.
  std::vector<host::Remark> remarks() const;

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

}  // namespace sphere_propagation
