// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What is the same of several phases or files is said once, with their names.

#include <string>
#include <vector>

#include "host/filter.h"

namespace sphere_propagation {

/// Remarks on layers that are yet to be made, in the order of the first of each kind. Those of one
/// message are one, of all layers that it is about, when they differ in numbers at most: "12 to
/// 25".
class SharedRemarks {
 public:
  template <class... Values>
  void add(const std::string& layer, const host::Message& message, const Values&... values) {
    add(layer, message, std::vector<std::string>{host::inWords(values)...});
  }
  void add(const std::string& layer, const host::Message& message,
           const std::vector<std::string>& values);
  /// layers: what `subject` is about.
  void add(const std::string& subject, const host::Remark& remark,
           const std::vector<std::string>& layers);
  void add(const std::string& layer, const host::Remark& remark) { add(layer, remark, {layer}); }
  void tell(const host::Task& task) const;

 private:
  struct Kind {
    const host::Message* message = nullptr;  // none: the remark as it is
    host::Remark remark;
    std::vector<std::vector<std::string>> values;  // by gap: of each layer
    std::vector<std::string> subjects, layers;
  };
  std::vector<Kind> kinds_;
};

/// "a label 1 phase 3", "a label 1 phases 0 to 4, 7", "a_1 label 1, a_2 label 1 and 7 more".
std::string namesOf(const std::vector<std::string>& layers);

}  // namespace sphere_propagation
