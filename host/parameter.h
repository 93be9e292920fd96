// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The parameters of a filter, in no host's words.

#include <cstddef>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "host/messages.h"

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

  /// The label with the remark, in lines that leave the dialog on a small screen.
  std::string dialogLabel() const {
    if (note.empty()) return label;
    constexpr size_t width = 44;
    std::string text = label + "\n(" + note + ")";
    size_t begin = label.size() + 1, blank = begin;  // of the line, and its last blank
    for (size_t i = begin; i < text.size(); ++i) {
      if (i - begin > width && blank > begin) {
        text[blank] = '\n';
        begin = blank + 1;
        blank = begin;
      }
      if (text[i] == ' ') blank = i;
    }
    return text;
  }

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

/// A value of an enum, and what dialog and scripts call it. One list of these per parameter is the
/// only place that says which name means what, whatever the order of the enum:
///   constexpr host::Named<Alignment> alignments[]{{"Rigid", Alignment::Rigid}, ...};
/// A list's order is that of the numbers in filter scripts: it must not change.
template <class Enum>
struct Named {
  const char* name;
  Enum value;
};

/// The parameter's default.
template <class Enum, size_t N>
Parameter::Choice choiceOf(const Named<Enum> (&all)[N], const Enum& chosen) {
  Parameter::Choice choice;
  for (size_t i = 0; i < N; ++i) {
    choice.names.emplace_back(all[i].name);
    if (all[i].value == chosen) choice.chosen = static_cast<int>(i);
  }
  return choice;
}

/// What the user chose.
class ParameterValues {
 public:
  virtual ~ParameterValues() = default;
  virtual bool flag(const std::string& name) const = 0;
  virtual int integer(const std::string& name) const = 0;
  virtual double real(const std::string& name) const = 0;
  virtual std::string text(const std::string& name) const = 0;
  /// The index into Choice::names, or any other number: a filter script may hold what it likes.
  virtual int index(const std::string& name) const = 0;
  virtual int layerId(const std::string& name) const = 0;
  virtual std::string file(const std::string& name) const = 0;     ///< a path; empty: none chosen
  virtual std::string newFile(const std::string& name) const = 0;  ///< a path; empty: none

  /// The value chosen from the list that the parameter was made of. Throws ParameterError when it
  /// is none of them.
  template <class Enum, size_t N>
  Enum choice(const std::string& name, const Named<Enum> (&all)[N]) const {
    const int chosen = index(name);
    if (chosen < 0 || static_cast<size_t>(chosen) >= N)
      throw ParameterError(fill(messages::noSuchChoice.text, [&](std::string_view gap) {
        return gap == "1" ? name : gap == "2" ? std::to_string(chosen) : std::to_string(N - 1);
      }));
    return all[chosen].value;
  }
};

}  // namespace sphere_propagation::host
