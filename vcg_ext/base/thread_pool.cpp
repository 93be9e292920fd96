// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/thread_pool.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <new>
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
  int count = 0;
  std::atomic<int> next{0};
  int working = 0;    // workers that have joined the loop and not finished
  bool open = false;  // a worker that wakes too late does not join, so nobody waits for it
  long loop = 0;      // number of the loop: a worker takes part in each once
  bool stop = false;
  std::exception_ptr failure;  // of the first call that threw, which is this one:
  int failed = 0;

  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      stop = true;
    }
    wake.notify_all();
    for (std::thread& worker : workers) worker.join();
  }

  void start(int threads) {
    if (threads <= 1) return;
    workers.reserve(static_cast<size_t>(threads) - 1);  // a thread that runs is never without owner
    try {
      for (int i = 1; i < threads; ++i) workers.emplace_back([this] { work(); });
    } catch (const std::system_error&) {  // the system gives no more: those that run will do
    } catch (const std::bad_alloc&) {
    }
  }

  void takeCalls() {
    for (int i = next++; i < count; i = next++) {
      try {
        call(context, i);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex);
        if (failure && failed < i) continue;
        failure = std::current_exception();
        failed = i;
      }
    }
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
      takeCalls();
      lock.lock();
      if (--working == 0) done.notify_one();
    }
  }
};

ThreadPool::ThreadPool(int threads) : state_(std::make_unique<State>()) {
  if (threads <= 0) threads = static_cast<int>(std::thread::hardware_concurrency());
  state_->start(std::min(threads, maxThreads));
}

ThreadPool::~ThreadPool() = default;

int ThreadPool::threads() const { return 1 + static_cast<int>(state_->workers.size()); }

void ThreadPool::run(int count, void (*call)(const void*, int), const void* context) {
  State& s = *state_;
  {
    const std::lock_guard<std::mutex> lock(s.mutex);
    s.call = call;
    s.context = context;
    s.count = count;
    s.next = 0;
    s.open = true;
    ++s.loop;
  }
  s.wake.notify_all();
  s.takeCalls();
  std::exception_ptr failure;
  {
    std::unique_lock<std::mutex> lock(s.mutex);
    s.open = false;
    while (s.working > 0) s.done.wait(lock);
    failure.swap(s.failure);
  }
  if (failure) std::rethrow_exception(failure);
}

std::vector<double>& ThreadPool::partialSums(int ranges) {
  if (state_->partialSums.size() < static_cast<size_t>(ranges))
    state_->partialSums.resize(static_cast<size_t>(ranges));
  return state_->partialSums;
}

}  // namespace sphere_propagation
