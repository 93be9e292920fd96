// SPDX-License-Identifier: GPL-3.0-only
// MeshLab shows <br><br> where the files have <p>: the same in all versions, without space above.

#include "host/help.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace sphere_propagation::host {
namespace {

using Values = std::map<std::string, std::string>;

constexpr std::string_view lineBreak = "<br>";

/// What is true of every filter (warnings.h).
constexpr const char* ofWarnings =
    "<br><br>What deserves a look is said in the log, and returned to scripts as <b>warnings</b>.";

/// Where dialogs send for the rest: Apply is to stay on a small screen.
constexpr const char* moreInReference =
    "<br>More, with what it returns and references: docs/filters.md.";

[[noreturn]] void fail(const std::string& file, const std::string& what) {
  throw std::logic_error("help/" + file + ": " + what);
}

/// What lies between two marks; the position moves behind the second. Where one is not there,
/// nothing, and the position is npos.
std::string between(const std::string& text, const std::string& from, const std::string& to,
                    size_t& at) {
  const size_t mark = at == std::string::npos ? at : text.find(from, at);
  const size_t begin = mark == std::string::npos ? mark : mark + from.size();
  const size_t end = begin == std::string::npos ? begin : text.find(to, begin);
  if (end == std::string::npos) {
    at = end;
    return {};
  }
  at = end + to.size();
  return text.substr(begin, end - begin);
}

std::string withoutComments(std::string text) {
  for (size_t at = 0; (at = text.find("<!--", at)) != std::string::npos;)
    text.erase(at, text.find("-->", at) + 3 - at);
  return text;
}

std::string textOf(const std::string& name) {
  std::string text = embeddedText(name);
  if (text.empty()) fail(name, "no file");
  return withoutComments(std::move(text));
}

std::string filledIn(std::string text, const Values& values) {
  for (size_t at = 0; (at = text.find('{', at)) != std::string::npos;) {
    const size_t end = text.find('}', at);
    if (end == std::string::npos) throw std::logic_error("{ without }: " + text);
    const std::string name = text.substr(at + 1, end - at - 1);
    const auto given = values.find(name);
    const std::string value = given != values.end() ? given->second : textOf(name);
    text.replace(at, end + 1 - at, value);
    at += value.size();
  }
  return text;
}

/// One blank for any number of blanks and line ends, none at the ends and beside <br>.
std::string inOneLine(const std::string& text) {
  std::string line;
  bool isBlankDue = false;
  const auto isAt = [](const std::string& whole, size_t at) {
    return whole.compare(at, lineBreak.size(), lineBreak) == 0;
  };
  for (size_t at = 0; at < text.size(); ++at) {
    if (std::isspace(static_cast<unsigned char>(text[at])) != 0) {
      isBlankDue = true;
      continue;
    }
    const bool isAfterBreak =
        line.size() >= lineBreak.size() && isAt(line, line.size() - lineBreak.size());
    if (isBlankDue && !line.empty() && !isAfterBreak && !isAt(text, at)) line += ' ';
    isBlankDue = false;
    line += text[at];
  }
  return line;
}

std::string withBreaks(const std::string& text) {
  std::string result;
  size_t at = text.find("<p>");
  while (at != std::string::npos) {
    const size_t begin = at + 3;
    at = text.find("<p>", begin);
    if (!result.empty()) result.append(lineBreak).append(lineBreak);
    result += inOneLine(text.substr(begin, at - begin));
  }
  return result;
}

}  // namespace

Help::Help(std::string pythonName, const Values& values) : pythonName_(std::move(pythonName)) {
  const std::string text = filledIn(textOf(pythonName_), values);
  size_t at = 0;
  title_ = inOneLine(between(text, "<title>", "</title>", at));
  const size_t list = text.find("<dl>");
  info_ = withBreaks(text.substr(0, list));
  brief_ = info_.substr(0, info_.find("<br><br>"));
  if (title_.empty() || info_.empty()) fail(pythonName_, "no text");
  if (list == std::string::npos) return;
  const size_t end = text.find("</dl>", list);
  for (at = text.find("<dt ", list); at < end;) {
    const size_t next = std::min(text.find("<dt ", at + 1), end);
    const std::string name = between(text, "id=\"", "\">", at);
    const std::string label = inOneLine(between(text, "", "<dd>", at));
    if (name.empty() || label.empty() || at > next) fail(pythonName_, "no head");
    sections_[name] = {label, inOneLine(text.substr(at, next - at))};
    at = next;
  }
}

FilterDescription Help::describe(int menus, Arity arity) const {
  return {title_, pythonName_, info_ + ofWarnings, brief_ + moreInReference, menus, arity};
}

Parameter Help::parameter(const std::string& name, decltype(Parameter::value) value) const {
  const auto section = sections_.find(name);
  if (section == sections_.end()) fail(pythonName_, "no " + name);
  return {name, section->second.label, section->second.help, std::move(value)};
}

}  // namespace sphere_propagation::host
