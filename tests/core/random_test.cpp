// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/random.h"

#include <gtest/gtest.h>

namespace sphere_propagation {
namespace {

TEST(Random, UniformNumbersAreThoseOfNumpy) {
  std::mt19937 bits(0);  // numpy.random.RandomState(0).random_sample(2)
  EXPECT_EQ(uniformNumber(bits), 0.5488135039273248);
  EXPECT_EQ(uniformNumber(bits), 0.7151893663724195);
}

TEST(Random, NormalNumbersAreThoseOfNumpy) {
  std::mt19937 bits(0);  // numpy.random.RandomState(0).randn(2), which gives the second first
  const std::array<double, 2> pair = normalNumbers(bits);
  EXPECT_DOUBLE_EQ(pair[1], 1.764052345967664);
  EXPECT_DOUBLE_EQ(pair[0], 0.4001572083672233);
}

TEST(Random, NormalNumbersHaveTheMomentsOfTheirDistribution) {
  std::mt19937_64 bits(1);
  constexpr int pairs = 100000;
  double sum = 0, squares = 0, fourths = 0, products = 0;
  for (int i = 0; i < pairs; ++i) {
    const std::array<double, 2> pair = normalNumbers(bits);
    products += pair[0] * pair[1];
    for (const double x : pair) {
      sum += x;
      squares += x * x;
      fourths += x * x * x * x;
    }
  }
  // Five standard errors.
  EXPECT_NEAR(sum / (2 * pairs), 0, 5 * std::sqrt(1.0 / (2 * pairs)));
  EXPECT_NEAR(squares / (2 * pairs), 1, 5 * std::sqrt(2.0 / (2 * pairs)));
  EXPECT_NEAR(fourths / (2 * pairs), 3, 5 * std::sqrt(96.0 / (2 * pairs)));
  EXPECT_NEAR(products / pairs, 0, 5 * std::sqrt(1.0 / pairs));
}

}  // namespace
}  // namespace sphere_propagation
