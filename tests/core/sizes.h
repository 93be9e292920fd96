// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// How much tests compute, by what the program is for.

// NOLINTBEGIN(bugprone-reserved-identifier): named by the compilers' run-time libraries
extern "C" {
__attribute__((weak)) void __asan_init();
__attribute__((weak)) void __tsan_init();
}
// NOLINTEND(bugprone-reserved-identifier)

namespace sphere_propagation::test {

/// Is a sanitizer linked to this program? The tests themselves may be compiled without it.
inline bool underAddressSanitizer() { return &__asan_init != nullptr; }
inline bool underThreadSanitizer() { return &__tsan_init != nullptr; }
inline bool underSanitizer() { return underAddressSanitizer() || underThreadSanitizer(); }

/// The size of a mesh, or how many cases a test tries. A sanitizer looks for errors of memory and
/// for races, which small sizes meet as large ones do, and makes all of it twenty times as slow;
/// the released library is tested at full size, and held to the figures there.
inline int sizeFor(int released, int sanitized) { return underSanitizer() ? sanitized : released; }

}  // namespace sphere_propagation::test
