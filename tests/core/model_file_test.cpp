// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/model_file.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/core/test_shapes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/model/export/model_export.h"
#include "vcg_ext/model/named_landmarks.h"

namespace sphere_propagation::test {
namespace {

class ModelFile : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("model_file_") + info->name() + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string bytesOf(const std::string& file) const {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream all;
    all << stream.rdbuf();
    return all.str();
  }
  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
    return path(name);
  }
  std::string why(const std::string& file) const {
    try {
      readModel(file);
    } catch (const ParameterError& error) {
      return error.what();
    }
    return "";
  }
  ShapeModel exported(const std::string& file) const {
    const TrainingSet set = trainingSet(ellipsoids(6, 3), ellipsoidFaces());
    ShapeModel model = buildShapeModel(set);
    exportModel(file, model, set);
    return model;
  }

  std::filesystem::path folder_;
};

TEST_F(ModelFile, NamesOfLandmarksComeBack) {
  ShapeModel model = buildShapeModel(trainingSet(ellipsoids(4, 1), ellipsoidFaces()));
  model.landmarkNames = {{"apex", 3}, {"Z\xC3\xA4hn \xE2\x82\xAC \xF0\x9F\xAB\x80", 0}};
  exportModel(path("named.npz"), model, trainingSet(ellipsoids(4, 1), ellipsoidFaces()));
  EXPECT_EQ(readModel(path("named.npz")).landmarkNames, model.landmarkNames);
  model.landmarkNames = {{"cut \xC3", 1}};  // no UTF-8
  exportModel(path("named.npz"), model, trainingSet(ellipsoids(4, 1), ellipsoidFaces()));
  EXPECT_EQ(readModel(path("named.npz")).landmarkNames.begin()->first, "cut \xEF\xBF\xBD");
}

TEST(NamedLandmarks, AreThoseWherePointsLie) {
  const TrainingSet set = trainingSet(ellipsoids(3, 1), ellipsoidFaces());
  const auto at = [&](size_t shape, Eigen::Index landmark) -> Vector3 {
    return set.shapes()[shape].landmarks.row(landmark).transpose();
  };
  const Vector3 near(1e-7, 0, 0), off(1e-2, 0, 0);
  const std::map<std::string, Eigen::Index> named =
      namedLandmarks(set, {{{"on all", at(0, 5)}, {"on one", at(0, 7)}, {"two", at(0, 1)}},
                           {{"on all", at(1, 5) + near}, {"on one", at(1, 7) + off}},
                           {{"two", at(2, 2)}, {"nowhere", at(2, 4) + off}}});
  EXPECT_EQ(named, (std::map<std::string, Eigen::Index>{{"on all", 5}, {"on one", 7}}));
  EXPECT_THROW(namedLandmarks(set, {}), ArgumentError);
}

TEST_F(ModelFile, IsReadAsItWasWritten) {
  const ShapeModel model = exported(path("m.npz")), read = readModel(path("m.npz"));
  EXPECT_TRUE(read.mean == model.mean);
  EXPECT_TRUE(read.modes == model.modes);
  EXPECT_TRUE(read.eigenvalues == model.eigenvalues);
  EXPECT_TRUE(read.scores == model.scores);
  EXPECT_TRUE(read.faces == model.faces);
  EXPECT_DOUBLE_EQ(read.totalVariance, model.totalVariance);
}

// Whatever is wrong with a file ends in words, not in what lies beyond its end.
TEST_F(ModelFile, IsRefusedWhereItIsDamaged) {
  exported(path("m.npz"));
  const std::string whole = bytesOf(path("m.npz"));
  EXPECT_NE(why(path("none.npz")).find("cannot be read"), std::string::npos);
  EXPECT_NE(why(write("text.npz", "mean, modes")).find("no archive"), std::string::npos);
  EXPECT_NE(why(write("empty.npz", "")).find("no archive"), std::string::npos);
  for (size_t length = 1; length < whole.size(); length += whole.size() / 50)
    EXPECT_NE(why(write("short.npz", whole.substr(0, length))), "") << length;
  Random random(1);
  const size_t directory = whole.find("PK\x01\x02");
  for (int i = 0; i < 300; ++i) {  // with any answer, but with an answer
    std::string bent = whole;
    const size_t at = i % 2 == 0 ? directory + static_cast<size_t>(random.index(
                                                   static_cast<int>(whole.size() - directory)))
                                 : static_cast<size_t>(random.index(200));
    bent[at] = static_cast<char>(random.index(256));
    why(write("bent.npz", bent));
  }
}

TEST_F(ModelFile, SaysWhatIsMissing) {
  exported(path("m.npz"));
  std::string bytes = bytesOf(path("m.npz"));
  const auto renamed = [&](const std::string& from, const std::string& to) {
    std::string changed = bytes;
    for (size_t at = changed.find(from); at != std::string::npos; at = changed.find(from, at + 1))
      changed.replace(at, from.size(), to);
    return why(write("changed.npz", changed));
  };
  EXPECT_NE(renamed("modes.npy", "nodes.npy").find("no array \"modes\""), std::string::npos);
  EXPECT_NE(renamed("faces.npy", "Faces.npy").find("no array \"faces\""), std::string::npos);
  EXPECT_EQ(renamed("scores.npy", "Scores.npy"), "");
  EXPECT_NE(renamed("<f8", "<c8").find("<c8"), std::string::npos);
  EXPECT_NE(renamed("False", "True ").find("column by column"), std::string::npos);
  EXPECT_NE(renamed("(162, 3, )", "(3, 162, )").find("do not fit"), std::string::npos);
}

}  // namespace
}  // namespace sphere_propagation::test
