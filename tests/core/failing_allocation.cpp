// SPDX-License-Identifier: GPL-3.0-only
#include "tests/core/failing_allocation.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<bool> active{false};
std::atomic<long> left{0};

}  // namespace

namespace sphere_propagation::test {

FailingAllocation::FailingAllocation(long n) {
  left = n;
  active = true;
}
FailingAllocation::~FailingAllocation() { active = false; }
bool FailingAllocation::failed() const { return left < 0; }

}  // namespace sphere_propagation::test

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

// NOLINTBEGIN(cppcoreguidelines-no-malloc): this is where memory comes from
void* operator new(std::size_t size) {
  if (active.load(std::memory_order_relaxed) && left-- == 0) throw std::bad_alloc();
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
// NOLINTEND(cppcoreguidelines-no-malloc)

#endif
