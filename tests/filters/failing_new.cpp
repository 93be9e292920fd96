// SPDX-License-Identifier: GPL-3.0-only
// Preloaded into Python: lets one allocation by `operator new` fail (see test_out_of_memory.py).
#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<bool> active{false};
std::atomic<long> left{0};

}  // namespace

/// The n-th allocation from now on fails, once; 0 is the next.
extern "C" void fail_allocation(long n) {
  left = n;
  active = true;
}

/// How many allocations there were until the one that was to fail; negative behind it.
extern "C" long stop_failing() {
  active = false;
  return left;
}

void* operator new(std::size_t size) {
  if (active.load(std::memory_order_relaxed) && left-- == 0) throw std::bad_alloc();
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
