// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/fault.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <string>
#include <vector>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/sentence.h"

namespace sphere_propagation {
namespace {

std::string inText(std::string_view text, const std::string& value) {
  return fill(text, [&](std::string_view gap) { return gap == "n" ? value : ""; });
}

TEST(Sentence, FillsGaps) {
  EXPECT_EQ(inText("no gap", "3"), "no gap");
  EXPECT_EQ(inText("{n} of {n}.", "3"), "3 of 3.");
  EXPECT_EQ(inText("{n|edge has|edges have} one", "1"), "1 edge has one");
  EXPECT_EQ(inText("{n|edge has|edges have} one", "0"), "0 edges have one");
  EXPECT_EQ(inText("is{n} {", "a } b"), "isa } b {");
}

TEST(Sentence, LeavesOutWhatIsNotKnown) {
  EXPECT_EQ(inText("here[, from {other}].", "3"), "here.");
  EXPECT_EQ(inText("here[, from {n}].", "3"), "here, from 3.");
  EXPECT_EQ(inText("here[, from {n|a|b}].", "…"), "here, from … b.");
}

TEST(Sentence, NumeralsAreShortAndWholeNumbersWhole) {
  EXPECT_EQ(numeral(0), "0");
  EXPECT_EQ(numeral(1'000'000), "1000000");
  EXPECT_EQ(numeral(0.12345), "0.123");
  EXPECT_EQ(numeral(1.2e60), "1.2e+60");
}

TEST(Fault, EachHasANameAndASentenceOfTheLibrarysOwn) {
  const std::set<std::string> known = {"name",  "other", "detail", "count", "first", "others",
                                       "value", "low",   "high",   "Noun",  "noun",  "nouns"};
  std::set<std::string_view> names;
  for (int i = 0; i < faultCount; ++i) {
    const auto fault = static_cast<Fault>(i);
    EXPECT_TRUE(names.insert(nameOf(fault)).second) << nameOf(fault);
    const std::string_view sentence = sentenceOf(fault);
    ASSERT_FALSE(sentence.empty()) << nameOf(fault);
    EXPECT_NE(sentence.back(), '.') << sentence;
    for (const char* word : {"layer", "Layer", "filter", "MeshLab"})
      EXPECT_EQ(sentence.find(word), std::string_view::npos) << sentence;
    fill(sentence, [&](std::string_view gap) {
      EXPECT_TRUE(known.count(std::string(gap))) << gap << " in " << sentence;
      return "1";
    });
  }
}

TEST(Fault, IsStatedInTheReadersWordForASurface) {
  const Finding finding = Finding(Fault::NoCorrespondence, "a").against("b").of(7);
  EXPECT_EQ(statement(finding).substr(0, 44), "Surface \"a\" corresponds nowhere to surface \"");
  EXPECT_EQ(statement(finding, "layer").substr(0, 40),
            "Layer \"a\" corresponds nowhere to layer \"");
  EXPECT_EQ(statement(Finding(Fault::RootOutOfRange).of(1, 9).at(9, 0, 4), "layer"),
            "The root is layer 9, but the layers are numbered 0 to 4");
}

TEST(RangeError, SaysWhatAndWhatItMustBe) {
  const RangeError between("area weight", 1.5, Range::between(0, 1));
  EXPECT_EQ(std::string(between.what()), "The area weight must lie between 0 and 1; it is 1.5.");
  EXPECT_EQ(between.finding().name, "area weight");
  EXPECT_EQ(between.finding().value, 1.5);
  EXPECT_EQ(between.finding().high, 1);
  EXPECT_EQ(std::string(RangeError("number of threads", -1, Range::atLeast(0)).what()),
            "The number of threads must be 0 or more; it is -1.");
  EXPECT_EQ(std::string(RangeError("tolerance", 0, Range::above(0)).what()),
            "The tolerance must be above 0; it is 0.");
  EXPECT_EQ(std::string(RangeError("area weight", 1.0001, Range::between(0, 1)).what()),
            "The area weight must lie between 0 and 1; it is 1.0001.")
      << "as many digits as it takes to see that it is not 1";
}

TEST(RangeError, IsThrownOutsideTheRangeOnly) {
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  for (const double value : {-0.1, 1.1, nan, infinity, -infinity})
    EXPECT_THROW(requireRange("it", value, Range::between(0, 1)), RangeError) << value;
  for (const double value : {0.0, 0.5, 1.0})
    EXPECT_NO_THROW(requireRange("it", value, Range::between(0, 1))) << value;
  EXPECT_NO_THROW(requireRange("it", 0, Range::atLeast(0)));
  EXPECT_THROW(requireRange("it", infinity, Range::atLeast(0)), RangeError);
  EXPECT_THROW(requireRange("it", 0, Range::above(0)), RangeError);
}

}  // namespace
}  // namespace sphere_propagation
