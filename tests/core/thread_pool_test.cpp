// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/thread_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <vector>

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
