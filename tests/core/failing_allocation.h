// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Running out of memory on purpose.

namespace sphere_propagation::test {

/// While it lives, the n-th `operator new` of any thread fails (0: the next), once.
class FailingAllocation {
 public:
  /// Sanitizers replace `operator new` by their own.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  static constexpr bool possible = false;
#else
  static constexpr bool possible = true;
#endif
  explicit FailingAllocation(long n);
  ~FailingAllocation();
  FailingAllocation(const FailingAllocation&) = delete;
  FailingAllocation& operator=(const FailingAllocation&) = delete;
  bool failed() const;
};

}  // namespace sphere_propagation::test
