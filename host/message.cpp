// SPDX-License-Identifier: GPL-3.0-only
#include "host/message.h"

#include <string>

namespace sphere_propagation::host {

std::string Remark::line() const {
  const bool warning = kind == Message::Kind::Warning || kind == Message::Kind::LayerWarning;
  const char* const head = warning ? "Warning: " : kind == Message::Kind::Note ? "Note: " : "";
  return head + (subject.empty() ? subject : subject + ": ") + text;
}

std::string outline(const Message& message, Host host) {
  return Remark{
      message.kind, message.name, message.kind == Message::Kind::LayerWarning ? "…" : "",
      fill(withMenuEntries(std::string(message.text), host), [](std::string_view) { return "…"; })}
      .line();
}

std::string filled(const Message& message, const std::vector<std::string>& values) {
  // Menu entries first: what fills a gap is not ours.
  return fill(withMenuEntries(std::string(message.text), thisHost()), [&](std::string_view gap) {
    return values.at(static_cast<size_t>(std::stoi(std::string(gap))) - 1);
  });
}

}  // namespace sphere_propagation::host
