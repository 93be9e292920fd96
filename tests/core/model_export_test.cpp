// SPDX-License-Identifier: GPL-3.0-only
// What the files mean is tested from Python, by readers of other people; here the writing itself.

#include "vcg_ext/model/export/model_export.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <locale>
#include <sstream>

#include "tests/core/test_shapes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/model/export/formats.h"

namespace sphere_propagation {
namespace {

namespace fs = std::filesystem;

class ModelExport : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              (std::string("model_export_") + info->name() + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::vector<std::string> write(const std::string& name) const {
    return exportModel(path(name), model_, set_);
  }
  static std::string read(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  size_t files() const {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder_), {}));
  }

  std::string refusal(const std::string& name) const {
    try {
      write(name);
    } catch (const ExportError& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
  TrainingSet set_ = test::trainingSet(test::ellipsoids(4, 1), test::ellipsoidFaces());
  ShapeModel model_ = buildShapeModel(set_);
};

TEST_F(ModelExport, TheEndingChoosesTheFormat) {
  write("a.npz");
  write("a.JSON");
  write("a.h5");
  write("a.ply");
  write("a.csv");
  EXPECT_EQ(read(path("a.npz")), npzFile(model_));
  EXPECT_EQ(read(path("a.JSON")), statismoJson(model_));
  EXPECT_EQ(read(path("a.h5")), statismoFile(model_));
  EXPECT_EQ(read(path("a.ply")), plyFile(model_));
  EXPECT_EQ(read(path("a.csv")), scoresTable(model_));
  EXPECT_EQ(files(), 5u);
}

TEST_F(ModelExport, ParticlesAreOneFilePerShapeBesideTheMean) {
  const auto written = write("heart.v2.particles");
  ASSERT_EQ(written.size(), 5u);
  EXPECT_EQ(read(path("heart.v2.particles")), particlesFile(model_.mean));
  for (size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(written[k + 1], path("heart.v2_00" + std::to_string(k) + ".particles"));
    EXPECT_EQ(read(written[k + 1]), particlesFile(set_.shapes()[k].landmarks));
  }
  EXPECT_EQ(files(), 5u);
}

TEST_F(ModelExport, ReplacesAnEarlierFile) {
  std::ofstream(path("a.csv")) << std::string(1000000, 'x');
  write("a.csv");
  EXPECT_EQ(read(path("a.csv")), scoresTable(model_));
  EXPECT_EQ(files(), 1u);
}

TEST_F(ModelExport, RefusesWithTheReason) {
  fs::create_directories(folder_ / "folder.npz");
  const auto says = [this](const std::string& name, const std::string& words) {
    const std::string text = refusal(name);
    EXPECT_NE(text.find(words), std::string::npos) << name << ": " << text;
    EXPECT_NE(text.find(name), std::string::npos) << text;
  };
  says("model", "no ending");
  says("model.xyz", "\".xyz\" is no format");
  says("model.xyz", ".npz, .h5, .json, .particles, .ply, .csv");
  says("missing/model.npz", "no folder");
  says("folder.npz", "is a folder");
  EXPECT_EQ(files(), 1u);
}

TEST_F(ModelExport, KeepsTheOldFileWhenWritingFails) {
  std::ofstream(path("a.csv")) << "old";
  fs::create_directories(folder_ / "a.csv.part");  // so that no new file can be made beside it
  EXPECT_NE(refusal("a.csv").find("a.csv"), std::string::npos);
  EXPECT_EQ(read(path("a.csv")), "old");
}

TEST_F(ModelExport, DoesNotDependOnTheLocale) {
  const std::string expected =
      particlesFile(model_.mean) + statismoJson(model_) + plyFile(model_) + scoresTable(model_);
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  EXPECT_EQ(
      particlesFile(model_.mean) + statismoJson(model_) + plyFile(model_) + scoresTable(model_),
      expected);
  std::locale::global(before);
}

TEST_F(ModelExport, TextReadsBackExactly) {
  std::istringstream lines(particlesFile(model_.mean));
  for (Eigen::Index j = 0; j < model_.mean.rows(); ++j)
    for (int k = 0; k < 3; ++k) {
      double value = 0;
      lines >> value;
      EXPECT_EQ(value, model_.mean(j, k));
    }
}

TEST_F(ModelExport, QuotesNamesInTables) {
  model_.names[1] = "a \"heart\", small";
  EXPECT_NE(scoresTable(model_).find("\r\n\"a \"\"heart\"\", small\","), std::string::npos);
}

TEST_F(ModelExport, AModelWithoutModesCanBeWritten) {
  const Points shape = set_.shapes()[0].landmarks;
  set_ = test::trainingSet({shape, shape}, test::ellipsoidFaces());
  model_ = buildShapeModel(set_);
  for (const char* name : {"a.npz", "a.h5", "a.json", "a.particles", "a.ply", "a.csv"})
    EXPECT_NO_THROW(write(name)) << name;
}

}  // namespace
}  // namespace sphere_propagation
