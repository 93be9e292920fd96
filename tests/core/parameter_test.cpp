// SPDX-License-Identifier: GPL-3.0-only
#include "host/parameter.h"

#include <gtest/gtest.h>

#include <limits>
#include <sstream>

namespace sphere_propagation::host {
namespace {

enum class Fruit { Apple, Pear, Quince };
// Not in the order of the enum, and not all of it.
constexpr Named<Fruit> fruits[]{{"Quince", Fruit::Quince}, {"Apple", Fruit::Apple}};

class Chosen : public ParameterValues {
 public:
  explicit Chosen(int index) : index_(index) {}
  bool flag(const std::string&) const override { return false; }
  int integer(const std::string&) const override { return 0; }
  double real(const std::string&) const override { return 0; }
  std::string text(const std::string&) const override { return {}; }
  int index(const std::string&) const override { return index_; }
  int layerId(const std::string&) const override { return -1; }
  std::string file(const std::string&) const override { return {}; }
  std::string newFile(const std::string&) const override { return {}; }

 private:
  int index_;
};

TEST(Choice, HasTheNamesOfTheListAndTheDefaultsPlace) {
  const Parameter::Choice choice = choiceOf(fruits, Fruit::Apple);
  EXPECT_EQ(choice.names, (std::vector<std::string>{"Quince", "Apple"}));
  EXPECT_EQ(choice.chosen, 1);
}

TEST(Choice, MeansTheValueBesideTheName) {
  EXPECT_EQ(Chosen(0).choice("fruit", fruits), Fruit::Quince);
  EXPECT_EQ(Chosen(1).choice("fruit", fruits), Fruit::Apple);
}

TEST(Choice, RefusesWhatIsNotInTheList) {
  for (const int index :
       {-1, 2, std::numeric_limits<int>::max(), std::numeric_limits<int>::min()}) {
    try {
      Chosen(index).choice("fruit", fruits);
      FAIL() << index;
    } catch (const ParameterError& error) {
      EXPECT_EQ(error.what(), "fruit is " + std::to_string(index) + ", but must be 0 to 1.");
    }
  }
}

TEST(DialogLabel, BreaksARemarkIntoShortLines) {
  Parameter parameter{"root", "Root layer", "", false};
  EXPECT_EQ(parameter.dialogLabel(), "Root layer");
  parameter.note =
      "layer 12 \"" + std::string(60, 'x') + "\" is the largest (volume 2.1e+05, this one 1.1e+05)";
  const std::string label = parameter.dialogLabel();
  EXPECT_EQ(label.rfind("Root layer\n(layer 12\n\"xxx", 0), 0u) << label;
  std::string joined = label;
  for (char& c : joined)
    if (c == '\n') c = ' ';
  EXPECT_EQ(joined, "Root layer (" + parameter.note + ")");
  parameter.note = "layer 0 \"ventricle 0\" is the largest (volume 1.08e+05, this one 8.6e+04)";
  std::istringstream lines(parameter.dialogLabel());
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 46u) << line;
}

}  // namespace
}  // namespace sphere_propagation::host
