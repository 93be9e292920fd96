// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/thread_pool.h"

#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <new>
#include <thread>
#include <vector>

#include "tests/core/failing_allocation.h"

namespace sphere_propagation::test {
namespace {

TEST(ThreadPool, TakesThousandsForAFew) { EXPECT_LE(ThreadPool(100000).threads(), 256); }

TEST(ThreadPool, DoesEveryTaskAndThrowsTheFirstFailure) {
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    for (const int count : {0, 1, 2, 50}) {
      std::vector<std::atomic<int>> visits(static_cast<size_t>(count));
      pool.forEach(count, [&](int i) { ++visits[i]; });
      for (const auto& v : visits) EXPECT_EQ(v, 1);
    }
    std::atomic<int> done{0};
    try {
      pool.forEach(20, [&](int i) {
        ++done;
        if (i % 7 == 3) throw i;
      });
      FAIL() << "no exception";
    } catch (int i) {
      EXPECT_EQ(i, 3);
    }
    EXPECT_EQ(done, 20);
  }
}

TEST(ThreadPool, AFailureInARangeReachesTheCallerWhereverItHappened) {
  constexpr int ranges = 40, count = ranges * ThreadPool::rangeSize;
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    const std::thread::id caller = std::this_thread::get_id();
    for (const bool onCaller : {true, false}) {
      std::atomic<int> done{0}, failed{0};
      const auto f = [&](int, int) {
        ++done;
        if ((std::this_thread::get_id() == caller) == onCaller) {
          ++failed;
          throw std::bad_alloc();
        }
        while (threads > 1 && failed == 0) std::this_thread::yield();  // until the others are here
      };
      try {
        pool.forRanges(count, f);
        EXPECT_EQ(failed, 0);
      } catch (const std::bad_alloc&) {
        EXPECT_GT(failed, 0);
      }
      EXPECT_EQ(done, ranges);
      EXPECT_EQ(failed > 0, onCaller || threads > 1);
    }
  }
}

TEST(ThreadPool, ThrowsTheFailureOfTheFirstRangeAndWorksOn) {
  constexpr int count = 40 * ThreadPool::rangeSize;
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    for (int again = 0; again < 50; ++again) {
      const auto failing = [](int begin, int) -> double {
        const int range = begin / ThreadPool::rangeSize;
        if (range % 9 >= 5) throw range;
        return 1;
      };
      for (const int ranges : {7, 40}) {
        try {
          pool.sum(ranges * ThreadPool::rangeSize, failing);
          FAIL() << "no exception";
        } catch (int range) {
          EXPECT_EQ(range, 5);
        }
      }
      EXPECT_EQ(pool.sum(count, [](int begin, int end) { return end - begin; }), count);
    }
  }
}

TEST(ThreadPool, LoopsAllocateNothing) {
  if (!FailingAllocation::possible()) GTEST_SKIP() << "the sanitizer has its own operator new";
  ThreadPool pool(3);
  const auto ranges = [&] { pool.forRanges(100000, [](int, int) {}); };
  const auto sum = [&] { return pool.sum(100000, [](int, int) { return 1.0; }); };
  sum();
  const FailingAllocation failing(0);
  ranges();
  sum();
  pool.forEach(20, [](int) {});
  EXPECT_FALSE(failing.failed());
}

TEST(ThreadPool, ComesUpWithFewerThreadsOrAnErrorWhenMemoryRunsOut) {
  if (!FailingAllocation::possible()) GTEST_SKIP() << "the sanitizer has its own operator new";
  int errors = 0, fewer = 0;
  for (long n = 0;; ++n) {
    try {
      const FailingAllocation failing(n);
      ThreadPool pool(4);
      std::atomic<int> done{0};
      pool.forEach(20, [&](int) { ++done; });
      EXPECT_EQ(done, 20);
      if (!failing.failed()) break;
      EXPECT_LT(pool.threads(), 4);
      ++fewer;
    } catch (const std::bad_alloc&) {
      ++errors;
    }
  }
  EXPECT_GT(errors, 0);
  EXPECT_EQ(fewer, 3);
}

/// In a process of its own, of a user who may have no more threads.
TEST(ThreadPool, DoesWithTheThreadsThatTheSystemGives) {
  if (test::underThreadSanitizer()) {
    GTEST_SKIP() << "the thread sanitizer knows no threads after a fork";
  }
  const auto inAProcessThatMayHaveNoThreads = [] {
    const rlimit none{0, 0};
    if (setrlimit(RLIMIT_NPROC, &none) != 0) _exit(2);
    if (getuid() == 0 && setuid(65534) != 0) _exit(2);  // root has no limit
    ThreadPool pool(4);
    std::atomic<int> done{0};
    pool.forEach(20, [&](int) { ++done; });
    _exit(pool.threads() == 1 && done == 20 ? 0 : 1);
  };
  const pid_t child = fork();
  if (child == 0) inAProcessThatMayHaveNoThreads();
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == 2) GTEST_SKIP() << "threads cannot be forbidden here";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(ThreadPool, MakesObjectsInOrder) {
  struct Square {
    explicit Square(int of) : value(of * of) {}
    int value;
  };
  for (int threads : {1, 3}) {
    ThreadPool pool(threads);
    const std::vector<Square> squares = pool.makeEach(100, [](int i) { return Square(i); });
    ASSERT_EQ(squares.size(), 100U);
    for (int i = 0; i < 100; ++i) EXPECT_EQ(squares[static_cast<size_t>(i)].value, i * i);
    EXPECT_TRUE(pool.makeEach(0, [](int i) { return Square(i); }).empty());
  }
}

TEST(ThreadPool, VisitsEveryIndexOnce) {
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    EXPECT_EQ(pool.threads(), threads);
    for (const int count : {0, 1, ThreadPool::rangeSize, ThreadPool::worthwhile + 1, 100000}) {
      std::vector<std::atomic<int>> visits(static_cast<size_t>(count));
      pool.forRanges(count, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) ++visits[i];
      });
      for (const std::atomic<int>& visit : visits) ASSERT_EQ(visit, 1);
    }
  }
}

TEST(ThreadPool, SumsAreTheSameToTheLastBitWithAnyNumberOfThreads) {
  const auto sumWith = [](int threads) {
    ThreadPool pool(threads);
    return pool.sum(200000, [](int begin, int end) {
      double sum = 0;
      for (int i = begin; i < end; ++i) sum += std::sin(i) / (1 + i % 7);
      return sum;
    });
  };
  const double alone = sumWith(1);
  for (const int threads : {2, 3, 8}) EXPECT_EQ(sumWith(threads), alone);
}

TEST(ThreadPool, RunsManyShortLoops) {
  ThreadPool pool(3);
  constexpr int count = 5 * ThreadPool::rangeSize;
  std::vector<int> value(count, 0);
  for (int loop = 0; loop < 2000; ++loop)
    pool.forRanges(count, [&](int begin, int end) {
      for (int i = begin; i < end; i += 64) ++value[i];
    });
  for (int i = 0; i < count; i += 64) ASSERT_EQ(value[i], 2000);
}

TEST(ThreadPool, ZeroMeansTheMachines) { EXPECT_GE(ThreadPool(0).threads(), 1); }

}  // namespace
}  // namespace sphere_propagation::test
