// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The parameters of a filter, in no host's words.

#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace sphere_propagation::host {

/// One parameter: its type is that of its value.
struct Parameter {
  struct Choice {
    std::vector<std::string> names;
    int chosen = 0;
  };
  struct LayerId {
    int id = 0;
  };
  /// A file to be read.
  struct File {
    std::string filter;  ///< what the file dialog offers: "Volumes (*.nii *.nrrd)"
  };
  /// A file to be written; none by default.
  struct NewFile {
    std::string filter;  ///< what the file dialog offers: "NumPy (*.npz);;Table (*.csv)"
  };

  std::string name;   ///< lower_snake, what scripts say
  std::string label;  ///< what the dialog says
  std::string help;   ///< the tooltip: one or two sentences, with unit and range
  std::variant<bool, int, double, std::string, Choice, LayerId, File, NewFile>
      value;  ///< the default
  bool advanced = false;
  std::string note = {};  ///< a remark on this project, which the dialog shows with the label

  std::string dialogLabel() const { return note.empty() ? label : label + "\n(" + note + ")"; }

  /// The same parameter, shown among the advanced ones.
  Parameter asAdvanced() && {
    advanced = true;
    return std::move(*this);
  }
  /// The same parameter with a remark, if it is not empty.
  Parameter withNote(std::string remark) && {
    note = std::move(remark);
    return std::move(*this);
  }
};

/// What the user chose.
class ParameterValues {
 public:
  virtual ~ParameterValues() = default;
  virtual bool flag(const std::string& name) const = 0;
  virtual int integer(const std::string& name) const = 0;
  virtual double real(const std::string& name) const = 0;
  virtual std::string text(const std::string& name) const = 0;
  virtual int choice(const std::string& name) const = 0;  ///< index into Choice::names
  virtual int layerId(const std::string& name) const = 0;
  virtual std::string file(const std::string& name) const = 0;     ///< a path; empty: none chosen
  virtual std::string newFile(const std::string& name) const = 0;  ///< a path; empty: none
};

}  // namespace sphere_propagation::host
