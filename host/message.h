// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What filters say. Each plugin keeps its texts in a catalogue (messages.def), which is what the
/// page docs/errors.md is checked against; the gaps in them are {1}, {2} (vcg_ext/base/sentence.h),
/// and filters of MeshLab's own stand in angle brackets (remedies.h).

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/remedies.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/base/sentence.h"

namespace sphere_propagation::host {

struct Message {
  enum class Kind {
    Refusal,       ///< thrown: nothing is changed
    Warning,       ///< the result deserves a look
    LayerWarning,  ///< the same of a layer, which is named before the text
    Note,          ///< advice
    News,          ///< what was done
    Summary        ///< where the job stands and what comes next: the last line of the log
  };
  const char* name;
  Kind kind;
  std::string_view text;
};

/// A message about a result: for the log, and for scripts where it deserves their attention
/// (warnings.h).
struct Remark {
  Message::Kind kind = Message::Kind::News;
  std::string name;     ///< of the message; empty: news that have none
  std::string subject;  ///< whose it is, before the text: a layer, or several in short, as "heart
                        ///< phases 0 to 4"; empty: the text speaks for itself
  std::string text;
  std::vector<std::string> layers{};  ///< all that it is about, also those that the text names;
                                      ///< none: the result as a whole

  /// "Warning: phase 3: it lies in another pose ...".
  std::string line() const;
};

// What goes into gaps.
inline std::string inWords(const std::string& text) { return text; }
inline std::string inWords(const char* text) { return text; }
inline std::string inWords(double number) { return numeral(number); }
inline std::string inWords(int number) { return std::to_string(number); }
inline std::string inWords(long number) { return std::to_string(number); }
inline std::string inWords(size_t number) { return std::to_string(number); }

/// The line of the log, or the error, with "…" in the gaps, as the pages show it.
std::string outline(const Message& message, Host host = Host::MeshLab2025);

std::string filled(const Message& message, const std::vector<std::string>& values);

/// The text with these values in its gaps.
template <class... Values>
std::string said(const Message& message, const Values&... values) {
  return filled(message, {inWords(values)...});
}

/// What a message says of a layer; layer empty: of the result as a whole.
template <class... Values>
Remark remarkOn(const std::string& layer, const Message& message, const Values&... values) {
  std::vector<std::string> layers;
  if (!layer.empty()) layers.push_back(layer);
  return {message.kind, message.name, layer, said(message, values...), std::move(layers)};
}

/// What a filter refuses; its text is the message's.
class Refusal : public Error {
 public:
  template <class... Values>
  explicit Refusal(const Message& message, const Values&... values)
      : Error(said(message, values...)) {}
};

}  // namespace sphere_propagation::host
