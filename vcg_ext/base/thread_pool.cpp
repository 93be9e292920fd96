// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/thread_pool.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>

namespace sphere_propagation {
namespace {

constexpr int maxThreads =
    256;  // thousands take the memory that the system has for threads, and end the process

}  // namespace

struct ThreadPool::State {
  std::vector<std::thread> workers;
  std::vector<double> partialSums;
  std::mutex mutex;
  std::condition_variable wake, done;
  // Of the loop that is being run; guarded by the mutex except for `next`.
  void (*call)(const void*, int) = nullptr;
  const void* context = nullptr;
  int ranges = 0;
  std::atomic<int> next{0};
  int working = 0;    // workers that have joined the loop and not finished
  bool open = false;  // a worker that wakes too late does not join, so nobody waits for it
  long loop = 0;      // number of the loop: a worker takes part in each once
  bool stop = false;

  void takeRanges() {
    for (int i = next++; i < ranges; i = next++) call(context, i);
  }

  void work() {
    long seen = 0;
    std::unique_lock<std::mutex> lock(mutex);
    for (;;) {
      while (!stop && !(open && loop != seen)) wake.wait(lock);
      if (stop) return;
      seen = loop;
      ++working;
      lock.unlock();
      takeRanges();
      lock.lock();
      if (--working == 0) done.notify_one();
    }
  }
};

ThreadPool::ThreadPool(int threads) : state_(std::make_unique<State>()) {
  if (threads <= 0) threads = static_cast<int>(std::thread::hardware_concurrency());
  threads = std::min(threads, maxThreads);
  try {
    for (int i = 1; i < threads; ++i) state_->workers.emplace_back([this] { state_->work(); });
  } catch (const std::system_error&) {  // the system gives no more: those that run will do
  }
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    state_->stop = true;
  }
  state_->wake.notify_all();
  for (std::thread& worker : state_->workers) worker.join();
}

int ThreadPool::threads() const { return 1 + static_cast<int>(state_->workers.size()); }

void ThreadPool::run(int ranges, void (*call)(const void*, int), const void* context) {
  State& s = *state_;
  {
    const std::lock_guard<std::mutex> lock(s.mutex);
    s.call = call;
    s.context = context;
    s.ranges = ranges;
    s.next = 0;
    s.open = true;
    ++s.loop;
  }
  s.wake.notify_all();
  s.takeRanges();
  std::unique_lock<std::mutex> lock(s.mutex);
  s.open = false;
  while (s.working > 0) s.done.wait(lock);
}

std::vector<double>& ThreadPool::partialSums(int ranges) {
  if (state_->partialSums.size() < static_cast<size_t>(ranges))
    state_->partialSums.resize(static_cast<size_t>(ranges));
  return state_->partialSums;
}

}  // namespace sphere_propagation
