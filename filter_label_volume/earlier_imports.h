// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What earlier imports left in the project, and how this one gets along with it: layers of the
/// same files are replaced, layers of other files of the same name stay, and those made now get a
/// name of their own.

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/filter.h"

namespace sphere_propagation {

/// Marks of imported layers (see host/layers.h): their file, by its full path; and the numbered
/// series that it was imported with, by its folder and what the names have in common.
constexpr const char* fileMark = "label_file";
constexpr const char* seriesMark = "label_series";

class EarlierImports {
 public:
  /// files: what is imported now, one or a series. labelText: " label 1" as layers are called.
  EarlierImports(const host::Layers& layers, const std::vector<std::string>& files,
                 std::string labelText);

  /// What the layers' names begin with, behind the file's stem: nothing; or, where layers of other
  /// files have that name, the parent folder's in brackets.
  const std::string& suffix() const { return suffix_; }

  /// Gives a layer its marks and the layer that it replaces: one of its name, of the same file or
  /// of an unknown one. file: its place in the list.
  void place(host::NewLayer& layer, size_t file);

  /// How many layers were replaced whose file is not known, as of layers read from files.
  long replacedUnknown() const { return replacedUnknown_; }

  /// Layers that an earlier import of the same files and labels made and this one does not make
  /// again. Those that the user renamed are none.
  std::vector<host::Layer> leftOver() const;

 private:
  /// A surface layer, looked at once: marks and labels take a while.
  struct Found {
    host::Layer layer;
    std::string label;
    std::optional<int> file;
    bool ofThisImport = false, replaced = false;
  };
  std::string chooseSuffix(const std::string& folder) const;

  std::vector<Found> surfaces_;
  std::map<std::string, std::vector<size_t>> called_;  // places in surfaces_, by label
  std::set<std::string> stems_;                        // of the files
  std::vector<int> fileMarks_;
  std::optional<int> series_;
  std::string labelText_, suffix_;
  long replacedUnknown_ = 0;
};

}  // namespace sphere_propagation
