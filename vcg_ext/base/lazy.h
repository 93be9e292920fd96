// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A value that is made when it is first asked for, whichever thread asks.

#include <mutex>
#include <optional>

namespace sphere_propagation {

template <class T>
class Lazy {
 public:
  /// make: returns the T; called once. What it throws reaches the caller, and the next one tries
  /// again.
  template <class Make>
  const T& get(const Make& make) const {
    std::call_once(once_, [&] { value_.emplace(make()); });
    return *value_;
  }

 private:
  mutable std::once_flag once_;
  mutable std::optional<T> value_;
};

}  // namespace sphere_propagation
