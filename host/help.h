// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What the user reads of a filter before it runs. The texts are HTML files, a browser shows them
/// as they are: help/PYTHON_NAME.html of the plugin, which cmake/EmbedTexts.cmake compiles into it.
///
///     <title>Menu entry</title>
///     <p> What the filter does in four to six lines of a dialog, which shows this paragraph alone.
///     <p> What else there is to know, what it returns, references; one <p> for each paragraph.
///     <dl>
///     <dt id="parameter_name">Label in the dialog
///     <dd>The parameter's help.
///     </dl>
///
/// Line breaks and blanks count as one blank, comments as nothing. {name} stands for a value that
/// the filter gives, or else for the text of help/name.html.

#include <map>
#include <string>

#include "host/filter.h"

namespace sphere_propagation::host {

/// The file NAME.html of the plugin's folder help; empty where there is none.
std::string embeddedText(const std::string& name);

/// The texts of one filter. A text that is not there is a mistake in the plugin, and throws
/// std::logic_error when the plugin is loaded.
class Help {
 public:
  explicit Help(std::string pythonName, const std::map<std::string, std::string>& values = {});

  /// menus: Menu values, or-ed.
  FilterDescription describe(int menus, Arity arity) const;
  FilterDescription describe(Menu menu, Arity arity) const {
    return describe(static_cast<int>(menu), arity);
  }
  /// A parameter with label and help from the file. value: its default.
  Parameter parameter(const std::string& name, decltype(Parameter::value) value) const;

 private:
  struct Section {
    std::string label, help;
  };
  std::string pythonName_, title_, info_, brief_;
  std::map<std::string, Section> sections_;  // by the parameters' names
};

}  // namespace sphere_propagation::host
