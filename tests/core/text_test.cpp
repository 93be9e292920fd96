// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/text.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <locale>

namespace sphere_propagation {
namespace {

struct CommaForPoint : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

/// Makes German of the numbers of streams while it lives.
class OtherLocale {
 public:
  OtherLocale() : before_(std::locale::global({std::locale::classic(), new CommaForPoint})) {}
  OtherLocale(const OtherLocale&) = delete;
  OtherLocale& operator=(const OtherLocale&) = delete;
  ~OtherLocale() { std::locale::global(before_); }

 private:
  std::locale before_;
};

TEST(Text, OneIsSingular) {
  EXPECT_EQ(counted(0, "edge", "edges"), "0 edges");
  EXPECT_EQ(counted(1, "edge", "edges"), "1 edge");
  EXPECT_EQ(counted(12000, "edge", "edges"), "12000 edges");
}

TEST(Text, ShortNumbersHaveThreeDigits) {
  EXPECT_EQ(shortNumber(0), "0");
  EXPECT_EQ(shortNumber(2), "2");
  EXPECT_EQ(shortNumber(12.345), "12.3");
  EXPECT_EQ(shortNumber(-0.0021449), "-0.00214");
  EXPECT_EQ(shortNumber(1234567), "1.23e+06");
  EXPECT_EQ(shortNumber(std::numeric_limits<double>::infinity()), "inf");
}

TEST(Text, ExactNumbersAreReadBackAsTheyWere) {
  for (const double value : {1.0 / 3, 0.1, 1e-300, -123456.789, 5e-324}) {
    ExactText text;
    text << value;
    EXPECT_EQ(std::strtod(text.str().c_str(), nullptr), value) << text.str();
  }
}

TEST(Text, NoLocaleChangesTheDecimalPoint) {
  const OtherLocale german;
  EXPECT_EQ(shortNumber(0.5), "0.5");
  EXPECT_EQ(counted(12000, "face", "faces"), "12000 faces");
  ExactText text;
  text << 1234.5;
  EXPECT_EQ(text.str(), "1234.5");
}

}  // namespace
}  // namespace sphere_propagation
