// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What a small HDF5 file holds, and the two forms it is written in: binary, and the HDF Group's
/// JSON.

#include <string>
#include <utility>
#include <vector>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// An array. Reals are declared as 32-bit floats and integers as 32-bit ones, little-endian both.
struct Hdf5Data {
  std::string name;
  std::vector<Eigen::Index> extents;  ///< none: a single number
  bool integers = false;
  std::vector<double> values;  ///< the last index runs fastest
};

struct Hdf5Group {
  std::string name;  ///< of the root: empty
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<Hdf5Group> groups;
  std::vector<Hdf5Data> data;
};

/// The bytes of an HDF5 file (The HDF Group, HDF5 File Format Specification, version 3.0) in its
/// oldest and most widely read form: superblock 0, groups as symbol tables, contiguous arrays,
/// attributes as strings of fixed length. pre: at most 8 members in a group, so that one node of a
/// symbol table holds them.
std::string hdf5File(const Hdf5Group& root);

/// The same as HDF5/JSON (the HDF Group's hdf5-json, version 1.1), with 17 digits. Ids are UUIDs
/// that depend on nothing but the order, so that the same content gives the same file.
std::string hdf5Json(const Hdf5Group& root);

}  // namespace sphere_propagation
