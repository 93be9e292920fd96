// SPDX-License-Identifier: GPL-3.0-only
// Numbers that stand for contents.

#include "vcg_ext/base/fingerprint.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace sphere_propagation {
namespace {

template <class... Parts>
int of(const Parts&... parts) {
  Fingerprint fingerprint;
  (fingerprint.add(parts), ...);
  return fingerprint.short24();
}

TEST(Fingerprint, StaysTheSameOnEveryMachine) {
  // By the published constants of SplitMix64: its first number from the seed 0 is
  // 0xe220a8397b1dcdaf.
  EXPECT_EQ(of(0), 0xe220a8);
  EXPECT_EQ(of(0.0), 0xe220a8);
}

TEST(Fingerprint, TellsContentsApart) {
  EXPECT_NE(of(1.0, 2.0), of(2.0, 1.0));
  EXPECT_NE(of(1.0), of(1.0, 0.0));
  EXPECT_NE(of(1.0), of(1.0 + 2.3e-16));
  EXPECT_NE(of(std::string("ab"), std::string("c")), of(std::string("a"), std::string("bc")));
  EXPECT_EQ(of(-0.0), of(0.0));
}

TEST(Fingerprint, IsANumberThatFloatsHold) {
  std::set<int> found;
  for (int i = 0; i < 1000; ++i) {
    const int number = of(i, 0.5 * i);
    EXPECT_GE(number, 1);
    EXPECT_LT(number, 1 << 24);
    EXPECT_EQ(static_cast<int>(static_cast<float>(number)), number);
    found.insert(number);
  }
  EXPECT_GE(found.size(), 999U);  // a pair among 1000 has one number in 3 % of all cases
}

}  // namespace
}  // namespace sphere_propagation
