// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A few threads that share loops, and wait without burning time when there is nothing to do.
///
/// Loops are cut into chunks whose size does not depend on the number of threads, and sums are
/// added up in the chunks' order: results are the same bit for bit with any number of threads.

#include <algorithm>
#include <exception>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

namespace sphere_propagation {

/// What the functions that loops call throw, out of memory included, reaches whoever runs the loop:
/// all calls are finished, then the exception of the first of them is thrown, whichever threads
/// they ran on. The pool can be used again. Such a function must not use its pool itself.
class ThreadPool {
 public:
  /// threads: how many work together, the calling one included; 0: as many as the machine runs at
  /// once; more than 256 are taken as 256. 1: no thread is started. Fewer are started where the
  /// system does not give that many.
  explicit ThreadPool(int threads = 1);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const;

  /// Below so many elements of a loop no thread but the calling one takes part: a pool would be of
  /// no use.
  static constexpr int worthwhile = 16384;

  /// Calls f(begin, end) for consecutive ranges that make up 0 .. count - 1, from several threads
  /// at once. Returns when all are done. Allocates nothing.
  template <class Function>
  void forRanges(int count, const Function& f) {
    const int ranges = rangesOf(count);
    const auto task = [&](int i) { f(beginOf(i), std::min(beginOf(i + 1), count)); };
    if (ranges <= inlineRanges || threads() == 1)
      runHere(ranges, task);
    else
      runTogether(ranges, task);
  }

  /// The sum of f(begin, end) over such ranges, added up in their order.
  template <class Function>
  double sum(int count, const Function& f) {
    std::vector<double>& parts = partialSums(rangesOf(count));
    forRanges(count, [&](int begin, int end) {
      parts[static_cast<size_t>(begin / rangeSize)] = f(begin, end);
    });
    double total = 0;
    for (int i = 0; i < rangesOf(count); ++i) total += parts[static_cast<size_t>(i)];
    return total;
  }

  /// Calls f(0), ..., f(count - 1), for a few long tasks that are independent of each other.
  template <class Function>
  void forEach(int count, const Function& f) {
    if (threads() == 1)
      runHere(count, f);
    else
      runTogether(count, f);
  }

  /// What f(0), ..., f(count - 1) return, in this order; otherwise as forEach.
  template <class Function>
  auto makeEach(int count, const Function& f) {
    using Made = std::decay_t<decltype(f(0))>;
    std::vector<std::optional<Made>> made(
        static_cast<size_t>(count));  // for types that only f can make
    forEach(count, [&](int i) { made[static_cast<size_t>(i)].emplace(f(i)); });
    std::vector<Made> all;
    all.reserve(made.size());
    for (std::optional<Made>& one : made) all.push_back(std::move(*one));
    return all;
  }

  static constexpr int rangeSize = 4096;
  static int rangesOf(int count) { return (count + rangeSize - 1) / rangeSize; }

 private:
  static constexpr int inlineRanges = worthwhile / rangeSize;
  static int beginOf(int range) { return range * rangeSize; }

  template <class Task>
  static void runHere(int count, const Task& task) {
    std::exception_ptr failure;
    for (int i = 0; i < count; ++i) {
      try {
        task(i);
      } catch (...) {
        if (!failure) failure = std::current_exception();
      }
    }
    if (failure) std::rethrow_exception(failure);
  }

  template <class Task>
  void runTogether(int count, const Task& task) {
    run(
        count, [](const void* context, int i) { (*static_cast<const Task*>(context))(i); }, &task);
  }

  void run(int count, void (*call)(const void*, int), const void* context);
  std::vector<double>& partialSums(int ranges);

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sphere_propagation
