// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Running out of memory on purpose.

#include "tests/core/sizes.h"

namespace sphere_propagation::test {

/// While it lives, the n-th `operator new` of any thread fails (0: the next), once.
class FailingAllocation {
 public:
  /// Not where a sanitizer replaces `operator new` by its own.
  static bool possible() { return !underSanitizer(); }
  explicit FailingAllocation(long n);
  ~FailingAllocation();
  FailingAllocation(const FailingAllocation&) = delete;
  FailingAllocation& operator=(const FailingAllocation&) = delete;
  bool failed() const;
};

}  // namespace sphere_propagation::test
